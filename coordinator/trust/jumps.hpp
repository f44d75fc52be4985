// A tick as a walk over leaves, from left to right: for every leaf the leaf that is ticked next when it succeeds, and
// when it fails. Composites only say where to go, so they vanish; what is left is a program without loops, which is
// what proofs over all observations walk (rule_check.hpp). Same result as tick() (common/tree/tick.hpp), and it knows
// which node had the last word.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/tree/condition.hpp"
#include "common/tree/tree.hpp"

namespace coppice {

// The tick is over. Greater than every node, so that a jump always goes forward.
inline constexpr std::size_t kTickEnds = kMaxTreeNodes;

struct Jump {
  std::size_t on_success = kTickEnds;
  std::size_t on_failure = kTickEnds;
};

// The leaf that a tick of this subtree comes to first. REQUIRES: node < tree.size().
std::size_t first_leaf(const Tree& tree, std::size_t node);

// [nodes]; that of a composite is what follows it as a whole.
std::vector<Jump> jumps_of(const Tree& tree);

// The action node that writes last, kTickEnds when none writes. REQUIRES: features holds every feature that is tested,
// jumps == jumps_of(tree).
std::size_t last_writer(const Tree& tree, std::span<const Jump> jumps, std::span<const std::uint8_t> features);

}  // namespace coppice
