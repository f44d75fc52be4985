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
// condition, a branch; and all swaps of two siblings. Scratch memory of one thread.
#pragma once

#include <cstddef>
#include <cstdint>
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

class EditRanking {
 public:
  // `chain` outlives this.
  explicit EditRanking(const Chain& chain);

  // The `count` best edits of `tree`, the best first; ties: fewer nodes, then in the order of places. Trees are
  // distinct. gains: [states x (actions + 1)], the last column being no action; finite. REQUIRES: check_tree(tree,
  // vocabulary).
  std::vector<RankedEdit> best(const Tree& tree, std::span<const double> gains, const EditLimits& limits,
                               std::size_t count);

  // What `actions`, an action table, gains. [states]
  double gain_of(std::span<const std::uint8_t> actions, std::span<const double> gains) const;

 private:
  struct Candidate;
  class Pass;

  const Chain& chain_;
  std::vector<std::uint32_t> slot_;        // [states x features], of the state's value among those of all features
  std::vector<std::uint32_t> first_slot_;  // [features + 1]
};

}  // namespace coppice
