// Where a tree and the policy differ, what that costs, and which branch would mend most of it.
//
// Cost of a state: visits x regret, with regret = V(s) - Q(s, the tree's action) and V(s) = Q(s, the policy's action),
// from the learned Q-table. Weighted with the tree's own expected visits this is the performance difference lemma
// (Kakade and Langford, "Approximately optimal approximate reinforcement learning", ICML 2002): summed over all states
// it is what the tree earns less than the policy, as far as Q is the policy's. A tree without an action stays where it
// is for ever, which is worth 0.
//
// Groups: for a conjunction C of at most so many tests and an action a, the saving is the sum over the states in C of
// visits x (Q(s, a) - Q(s, tree's action)): what is mended less what is spoilt. The best is found by depth-first search
// with the optimistic bound "as if only what is mended were kept" (subgroup discovery: Wrobel, PKDD 1997; Grosskreutz
// et al., ECML PKDD 2008), which is exact unless kMostConjunctions ends it. Then the tree counts as doing a in C, and
// the next group is sought, whose branch goes in front, so that it may make exceptions (sequential covering: Clark and
// Niblett, "The CN2 induction algorithm", Machine Learning 1989).
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/error.hpp"
#include "common/named.hpp"
#include "common/tree/tree.hpp"

namespace coppice {

inline constexpr std::size_t kMostConjunctions = 500'000;

// What a state weighs.
enum class Weighting : std::uint8_t {
  tree = 0,      // expected visits of the tree's walk through the chain, in an episode
  policy = 1,    // the same of the policy's walk
  learning = 2,  // visits while the policy was learned, per step, times the steps of an episode
  states = 3,    // every state the same: 1
};
template <>
inline constexpr std::array kNames<Weighting> = names("tree", "policy", "learning", "states");

struct Disagreement {
  std::size_t state = 0;
  double visits = 0.0;
  double regret =
      0.0;  // negative where the tree's action has the higher Q: never, the policy being greedy, but for ties
  double cost() const { return visits * regret; }
  ActionId policy{};
  ActionId tree = kNoAction;
  std::size_t writer = 0;  // the node with the last word; kTickEnds: none
};

struct Group {
  std::vector<Node> tests;  // conditions, all of which hold
  ActionId action{};
  double saved = 0.0;             // of the total cost
  std::size_t states = 0;         // of the chain in which the tests hold
  std::size_t disagreements = 0;  // of them: the tree differs from the policy now
  std::size_t mended = 0;         // of these: the policy's action is the group's
  std::size_t spoilt = 0;         // states in which tree and policy agree now, on another action than the group's
};

struct ExplainSettings {
  Weighting weighting = Weighting::tree;
  std::uint32_t steps = 150;  // of an episode
  std::uint32_t tests = 3;    // in a conjunction, at most
  std::uint32_t groups = 5;   // at most
};
// Error: a number out of range, by its flag.
Result<void> check_settings(const ExplainSettings& settings);

struct Explanation {
  ExplainSettings settings;
  std::size_t states = 0;
  double cost = 0.0;                        // of all disagreements
  std::vector<Disagreement> disagreements;  // the costliest first
  std::vector<Group> groups;                // in the order in which they were found
  bool complete = true;                     // every search for a group came to its end
};

// REQUIRES: check_settings(), check_tree(tree, chain.vocabulary()).
Explanation explain(const Chain& chain, const Tree& tree, const ExplainSettings& settings);

// "(sequence s3=3 move)".
Tree branch_of(const Group& group);
// The tree that tries the branch first and else does what it did.
Tree with_branch(const Tree& tree, const Tree& branch);

}  // namespace coppice
