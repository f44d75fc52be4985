// Local search that knows where to step: the best edits of a tree by what they gain to first order (edit_ranking.hpp),
// under the occupancy and advantages of what the tree itself does (policy_value.hpp), are solved exactly in turn, the
// first that improves is taken, and so on until none does. Where no single edit helps, two at a time are tried: what
// makes room at the least loss, or changes most, and then the best edit of what that leaves; and edits of two
// conditions. A step costs one factorisation, one look at the tree and a few more factorisations, where a blind local
// search evaluates edits by the hundred.
//
// What two edits do not leave is left by a leap: another condition in the place of one of the tree's, a part that goes,
// or an edit of two conditions, whatever it loses, and a climb from there (iterated local search: Lourenco, Martin and
// Stuetzle, Handbook of Metaheuristics, 2003, with the moves ranked instead of drawn). explore() begins with nothing: a
// beam of trees of one condition, each a local optimum, then of two, and so on (Lowerre, The HARPY speech recognition
// system, 1976), which for small budgets tries nearly all roots there are.
//
// What is climbed is a weighted sum of objectives,
//
//   sum over o of worth[o] x (along the walk: sum over s of d(s) score_o(s, a(s));  over states: sum of score_o(s,
//   a(s)))
//
// with d the discounted occupancy under the tree, by the job's gamma, or, for a job of t steps, by 1 - 1/t, whose walks
// are as long on average; an objective over states is known exactly. Weights that a front search draws anew for each
// child thus become directions to climb in. This is policy iteration within a class of small policies (as conservative
// policy iteration, Kakade and Langford 2002, and policy search by dynamic programming, Bagnell and others, NIPS 2003,
// with the class's own edits in place of a learner), so what it finds is a local optimum only: evolution is for the
// rest.
//
// A pure function of its arguments: no chance, the same bits everywhere. Scratch memory of one thread.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/chain/policy_value.hpp"
#include "common/error.hpp"
#include "common/evolution/edit_ranking.hpp"
#include "common/fitness/job.hpp"
#include "common/fitness/meaning.hpp"
#include "common/tree/state_columns.hpp"
#include "common/tree/tree.hpp"

namespace coppice {

class GuidedClimb {
 public:
  // `chain` outlives it. Errors: as make_score_table(); more states than can be solved (kMaxSolvedStates).
  static Result<std::unique_ptr<GuidedClimb>> make(const Chain& chain, const Job& job);

  struct Effort {
    std::uint32_t steps = 100;  // improving edits at most
    bool pairs = true;          // two edits at a time where none alone helps
    std::uint64_t leaps = 0;    // evaluations that leaps may cost
  };

  // What becomes of `start`. worth: [objectives of the job], for a mean score a step or a sum of scores over states.
  // REQUIRES: check_tree(start, vocabulary), `start` within the limits.
  Tree climb(const Tree& start, std::span<const double> worth, const EditLimits& limits, const Effort& effort);

  // Trees to begin with, the best first: what a beam finds that adds a condition at a time, up to eight. worth, limits:
  // as climb(). evaluations: that it may cost, about.
  std::vector<Tree> explore(std::span<const double> worth, const EditLimits& limits, std::uint64_t evaluations);

  // Exact evaluations so far.
  std::uint64_t solved() const { return solved_; }

 private:
  struct Table {
    bool along_walk = false;
    std::vector<double> scores;  // [states x (actions + 1)]
  };

  // A tree and what it is worth.
  struct Reached {
    Tree tree{ActionId{0}};
    double worth = 0.0;
  };
  // How one ascent goes.
  struct Ascent {
    std::uint32_t steps;
    std::size_t tries;  // edits that are evaluated before a tree counts as a local optimum
    bool pairs;
    bool merges;  // ends where an ascent has been before
  };

  GuidedClimb(const Chain& chain, double gamma, std::vector<Table> tables);
  void weigh(std::span<const double> worth);
  void begin(std::span<const double> worth);
  std::optional<double> worth_of(std::span<const std::uint8_t> actions);
  std::optional<double> stand_on(const Tree& tree);
  void fill(const Tree& tree, std::vector<std::uint8_t>& actions) const;
  void find_gains();
  std::vector<RankedEdit> pairs(const Tree& tree, const EditLimits& limits);
  bool step_up(std::vector<RankedEdit> edits, Reached& reached, std::size_t tries);
  void ascend(Reached& reached, const EditLimits& limits, const Ascent& ascent);
  std::vector<RankedEdit> leaps(const Tree& tree, const EditLimits& limits);
  bool leap(Reached& reached, const EditLimits& limits, std::uint64_t until);
  std::vector<Reached> grown(const std::vector<Reached>& beam, const EditLimits& limits, std::uint64_t until);

  const Chain& chain_;
  double gamma_;
  std::vector<Table> tables_;  // [objectives]
  StateColumns columns_;
  EditRanking ranking_;
  std::unique_ptr<PolicyValue> now_;                        // of the tree climbed so far
  std::unique_ptr<PolicyValue> next_;                       // of the edit being tried
  bool solved_now_ = false;                                 // now_ has been, for actions_
  std::vector<std::uint8_t> actions_;                       // [states], of the tree climbed so far
  std::vector<std::uint8_t> tried_;                         // [states]
  bool walks_ = false;                                      // some objective along the walk has a worth
  std::vector<double> walk_;                                // [states x (actions + 1)], weighted
  std::vector<double> states_;                              // [states x (actions + 1)], weighted
  std::vector<double> advantages_;                          // [states x (actions + 1)]
  std::vector<double> gains_;                               // [states x (actions + 1)]
  std::unordered_map<Meaning, double, MeaningHash> known_;  // what was tried since climb() began, and its worth
  std::unordered_set<Meaning, MeaningHash> passed_;         // what an ascent stood on since then
  std::uint64_t solved_ = 0;
};

}  // namespace coppice
