// The vocabulary and the chain that the fuzz targets and their corpus speak of: the UAV's sensors with "=", a
// coordinate with both operators and one with "<=" only, so that no branch of a parser is out of reach.
#pragma once

#include <memory>

#include "common/chain/chain.hpp"
#include "common/tree/tree.hpp"
#include "common/tree/vocabulary.hpp"

namespace coppice::fuzz {

const Vocabulary& words();

// A few states of words(), some pairs never tried.
Chain small_chain();

// The same with all that a chain can have: numbers and bins, several starts, an end, lacking actions, collisions.
Chain full_chain();

// That two trees of words() choose the same action for 64 observations, drawn once and the same for all trees.
void check_ticks_alike(const Tree& tree, const Tree& other);

}  // namespace coppice::fuzz
