// Every small change of a tree at once, ranked by what it gains. Where a search draws an edit and evaluates it, this
// one asks of all edits what the actions that they change are worth, given one number for each (state, action), and
// names the best: those are worth evaluating. With gains d(s) A(s, a) of a policy's occupancy and advantages
// (policy_value.hpp) that is the first-order change of its return; with the weight of a state where a is the policy's
// action, the exact change of the agreement there.
//
// One pass over the tree gives, for every place in it and every state, what the tick would select if the place failed,
// succeeded, or wrote an action and succeeded: the rest of the tick is fixed. Then any subtree put there is a choice
// between these by its conditions, and sums over the states, kept for each value of each feature, give the gain of
// every condition, action and branch at that place without looking at the states again (as regression trees find their
// splits: Breiman, Friedman, Olshen and Stone, Classification and Regression Trees, 1984, 8.4).
//
// Ranked are, at every node: another action or condition, a branch (sequence condition action), a choice between two
// actions, a condition before it, a branch before it, and its removal; in every gap between siblings: an action, a
// condition, a branch; and all swaps of two siblings. Asked for by themselves, because they cost more: edits of two
// conditions at once (a branch that asks both, or either, and a list of two branches with an action behind them), whose
// sums are those of one condition taken where the other holds. Scratch memory of one thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/tree/tree.hpp"

namespace coppice {

// What the edited tree may have; edits beyond are left out.
struct EditLimits {
  std::size_t max_nodes = kMaxTreeNodes;
  std::size_t max_conditions = kMaxTreeNodes;
  bool guarded = false;  // only edits that keep conditions before one action in every sequence, given such a tree
};

// A tree and what it gains in all against the policy that the gains belong to.
struct RankedEdit {
  double gain = 0.0;
  Tree tree{ActionId{0}};
};

struct ValueSlots;

class EditRanking {
 public:
  // `chain` outlives this.
  explicit EditRanking(const Chain& chain);
  EditRanking(const EditRanking&) = delete;
  EditRanking& operator=(const EditRanking&) = delete;
  ~EditRanking();

  // The `count` best edits of `tree`, the best first; ties: fewer nodes, then in the order of places. Trees are
  // distinct. gains: [states x (actions + 1)], the last column being no action; finite. REQUIRES: check_tree(tree,
  // vocabulary).
  std::vector<RankedEdit> best(const Tree& tree, std::span<const double> gains, const EditLimits& limits,
                               std::size_t count);

  // The same of the edits of two conditions: at every node and in every gap of a selector (sequence c d a) and
  // (sequence (selector c d) a), at every node (selector (sequence c a) (sequence d b) e), a, b and e being the best
  // where they act. c and d ask different features.
  std::vector<RankedEdit> best_of_two_conditions(const Tree& tree, std::span<const double> gains,
                                                 const EditLimits& limits, std::size_t count);

  // What `actions`, an action table, gains. [states]
  double gain_of(std::span<const std::uint8_t> actions, std::span<const double> gains) const;

 private:
  class Pass;

  const Chain& chain_;
  std::unique_ptr<const ValueSlots> slots_;
};

}  // namespace coppice
