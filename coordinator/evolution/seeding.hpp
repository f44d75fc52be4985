// Trees to begin with that are not grown blindly.
//
//   branches   a selector of single-condition branches, (sequence condition action), and an action
//   greedy     a decision list (Rivest, "Learning decision lists", Machine Learning 2, 1987) grown from the policy:
//   each
//              next branch is the condition and action that decide most of the still undecided states as the policy
//              does, beyond what the action at the end would; every state weighs 1 mixed with its visits by a random
//              share, and each branch chooses among a random half of the conditions, so that no two seeds need be
//              alike.
//
// A pure function of (chain, stream).
#pragma once

#include <optional>

#include "common/chain/chain.hpp"
#include "common/chain/random.hpp"
#include "common/tree/random_tree.hpp"
#include "common/tree/tree.hpp"
#include "coordinator/evolution/config.hpp"

namespace coppice {

// None: the shape has no room for a selector of branches. REQUIRES: seeding is not none.
std::optional<Tree> seed_tree(Seeding seeding, const Chain& chain, const TreeShape& shape, Stream& stream);

}  // namespace coppice
