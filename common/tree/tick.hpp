// One tick: the reference semantics of a tree, written to be read (thesis III-A, III-B). Everything faster
// (action_table.hpp) is tested against it.
#pragma once

#include <cstdint>
#include <span>

#include "common/tree/tree.hpp"

namespace coppice {

// Evaluates left to right from the root. An action node writes its action to the blackboard and succeeds. The
// result is the last action written before the root finishes, whether or not the root, or the branch that
// wrote it, succeeded; kNoAction when nothing was written.
// REQUIRES: features holds one value per feature that the tree tests.
ActionId tick(const Tree& tree, std::span<const std::uint8_t> features);

// The same for readings, each in its feature's own unit, also such as the vocabulary does not declare: "x=3" holds for
// 3 alone, "x<=0.5" for whatever is not above, whatever the last bin's name for all. What exported programs do.
// REQUIRES: check_tree(tree, vocabulary), one reading per feature, none NaN.
ActionId tick_readings(const Tree& tree, const Vocabulary& vocabulary, std::span<const double> readings);

}  // namespace coppice
