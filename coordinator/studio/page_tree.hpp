// One tree as the page needs it: its text, its figures on the chain and what each node does there; and the states of
// the chain, of which a large chain shows a part and says which. Pure functions of their arguments; no files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/tree/tree.hpp"
#include "coordinator/problem/problem.hpp"

namespace coppice {

// Names, values and actions, with what they mean where the problem says. Fields: README.md, "vocabulary".
// REQUIRES: the problem was made for the vocabulary.
nlohmann::ordered_json vocabulary_json(const Vocabulary& vocabulary, const Problem& problem);

// What is asked again after every edit, so it must be quick: 1 ms at the thesis' size. Fields: README.md, "tree".
// REQUIRES: check_tree(tree, chain.vocabulary()).
nlohmann::ordered_json tree_json(const Chain& chain, const Tree& tree, std::uint32_t steps);

// The figures of whoever takes the policy's actions: "figures" of tree_json() without nodes.
nlohmann::ordered_json policy_json(const Chain& chain, std::uint32_t steps);

// More than so many are not shown: those that the tree visits most, then the policy, then learning, a third each.
inline constexpr std::size_t kMostPageStates = 3000;
// Fields: README.md, "states". visits: [states] of the tree's walk and of the policy's.
nlohmann::ordered_json states_json(const Chain& chain, const std::vector<double>& tree_visits,
                                   const std::vector<double>& policy_visits);

}  // namespace coppice
