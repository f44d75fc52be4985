// Which tree of a front is the answer: the one that is worth most where it will be used. With a simulator, trees of the
// front run in it, over the same episodes for all of them, more episodes for those that are still in question: a race
// (Maron and Moore, "Hoeffding races", NIPS 1993; Birattari and others, "A racing algorithm for configuring
// metaheuristics", GECCO 2002), by paired differences, for trees that meet the same luck differ by less than their
// rewards do. Its figures are then measured on episodes that chose nothing. Fewer trees and episodes where the
// simulator is a program of the problem's own, in which a step costs a hundred times as much. Without a simulator the
// chain decides, by what was computed on it.
//
// First come the trees that are as safe as the policy: no collision where the policy has none, or not more than it has
// within the interval. Among these a preference decides:
//
//   balance, return   the highest reward; of those that earn as much, to half a percent in the simulator, the smallest
//   agreement         the most steps in which the policy would do the same, then the highest reward
//   coverage          the most states in which it would
//   size              the smallest that earns 97 % of what the policy does; if none does, the highest reward
//
// balance asks in addition for half of the steps to agree: a tree that does something else altogether explains nothing.
//
// A pure function of (study, front, configuration, seed): episodes are numbered, not drawn.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/error.hpp"
#include "common/evolution/config.hpp"
#include "common/stop.hpp"
#include "coordinator/evolution/pick.hpp"
#include "coordinator/report/score.hpp"
#include "coordinator/study/study.hpp"

namespace coppice {

// How a controller did, an episode. On the chain the margins are 0 and the reward is as the run measures it: expected
// over rollout.steps steps, or the discounted return.
struct Worth {
  Estimate reward;
  Estimate agreement;   // share of the steps; NaN: the run did not measure it
  Estimate collisions;  // steps
};

struct Answer {
  std::size_t member = 0;  // of the front
  Prefer prefer = Prefer::balance;
  bool simulated = false;      // else on the chain
  std::size_t tried = 0;       // trees that were in question
  std::uint64_t episodes = 0;  // that the figures are means of
  Worth tree;
  Worth policy;
  double on_chain = 0.0;           // reward of the tree, as the run measured it
  double policy_on_chain = 0.0;    // the same of the policy
  bool good = true;                // nothing to complain of
  std::vector<std::string> notes;  // what is wrong, why, and what to try next; sentences
};

struct AnswerProgress {
  std::function<bool()> go_on = {};  // asked between episodes; false to stop. May be empty.
  const StopFlag* stop = nullptr;    // see SimulateSettings::stop
};

// REQUIRES: front.members is not empty, config.front.prefer is not Prefer::pick. Errors: interrupted; the simulator.
Result<Answer> choose_answer(const Study& study, const Front& front, const EvolveConfig& config,
                             const AnswerProgress& progress);

// Lines for a person.
std::string to_text(const Answer& answer);

}  // namespace coppice
