// Q-values and policies that somebody else computed, brought to the states of a model.
//
//   .npy    Q [S x A] or [d1 x ... x dk x A], policy [S] or [d1 x ... x dk]: S counts the source's states, d1..dk the
//           whole-number readings of the k features
//   CSV     with a header: columns named as features, and for Q one named as each action, for a policy `action` (a name
//   or
//           an index); without: bare numbers, a line a state, [S x A] or [S]
//
// -inf and NaN stand for a forbidden action. A state that a table with features does not list has no values: Q 0 and
// the first action it has; it is counted. Plain values.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/error.hpp"
#include "coordinator/exchange/chain_of_model.hpp"
#include "coordinator/exchange/model.hpp"

namespace coppice {

struct GivenPolicy {
  std::vector<double> q;  // [states x actions]; NaN: forbidden, or the table has no such state. Empty: no Q given
  std::vector<ActionId> policy;  // [states]; with Q alone greedy, ties to the lowest index
  std::uint64_t unlisted = 0;    // states that the table does not have
  std::uint64_t unvisited = 0;   // states whose values are all 0
  std::uint64_t ties = 0;        // states whose best value is that of several actions, those of zeros aside
};

// REQUIRES: check_model(model); one of the paths is not empty. Errors name file and line, what was found and what was
// expected; a policy that takes an action that the state lacks.
Result<GivenPolicy> read_given_policy(const std::string& q_path, const std::string& policy_path, const Model& model);

// Pairs that the Q-table forbids lose their rows. Errors: a state would lose the last of its actions.
Result<void> forbid(const GivenPolicy& given, Model& model);

}  // namespace coppice
