// The action that a tree selects in every state of a chain: the tree's whole meaning on that chain. Bit-parallel:
// the tree is evaluated on blocks of 512 states at once, composites as masks of the states still active, the blackboard
// as ceil(log2(actions + 1)) bit planes. Equal to tick() on every state (a property test over random trees).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/simd.hpp"
#include "common/tree/state_columns.hpp"
#include "common/tree/tree.hpp"

namespace coppice {

// Writes the action index of every state to `actions`, `none` where the tree selects none.
// REQUIRES: check_tree() for the columns' vocabulary, actions.size() == columns.states(), simd none or best_simd().
void fill_action_table(const Tree& tree, const StateColumns& columns, std::uint8_t none,
                       std::span<std::uint8_t> actions, Simd simd = best_simd());

// The same as a value, kNoAction where the tree selects none. [states]
std::vector<ActionId> action_table(const Tree& tree, const StateColumns& columns);

}  // namespace coppice
