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
#include <span>
#include <string>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/chain/random.hpp"
#include "common/evolution/config.hpp"
#include "common/tree/random_tree.hpp"
#include "common/tree/tree.hpp"

namespace coppice {

// None: the shape has no room for a selector of branches. REQUIRES: seeding is not none.
std::optional<Tree> seed_tree(Seeding seeding, const Chain& chain, const TreeShape& shape, Stream& stream);

// The trees that ga.founders spells, in its order: they take the first slots of the first generation, so that a search
// goes on from what an earlier one, another method or a hand has made. Errors name the tree, by its number from 1: text
// that is no tree; a tree outside the limits of `ga`; more trees than a generation has.
Result<std::vector<Tree>> founders_of(const GaConfig& ga, const Vocabulary& vocabulary);
// What ga.founders is for these trees.
std::string founders_text(std::span<const Tree> trees, const Vocabulary& vocabulary);

}  // namespace coppice
