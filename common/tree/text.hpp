// The text form of a tree, one line, used in logs, on the command line and in tests:
//   (selector (sequence s3=0 turn_left) (sequence s1=3 s3=1 turn_left) move)
// Grammar: tree = leaf | "(" ("sequence" | "selector") tree+ ")"; leaf = action name | feature name op value;
// op = "=" | "<="; blanks (space, tab) separate. Names come from the vocabulary; values are written in the feature's
// own unit (Feature::number_text): pole_angle<=0.0419.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "common/tree/tree.hpp"

namespace coppice {

inline constexpr std::size_t kMaxTreeText = std::size_t{1} << 20U;  // characters

// Errors name the column (from 1), what was found (foreign characters escaped) and what was expected, with the names
// that exist. Whatever is returned passes check_tree() for the vocabulary. Never throws on any input.
Result<Tree> parse_tree(std::string_view text, const Vocabulary& vocabulary);

// parse_tree(to_text(tree)) gives the same tree. REQUIRES: check_tree(tree, vocabulary).
std::string to_text(const Tree& tree, const Vocabulary& vocabulary);

// One node without its children: "selector", "s3=0", "turn_left". REQUIRES: check_tree(tree, vocabulary).
std::string to_text(const Node& node, const Vocabulary& vocabulary);

}  // namespace coppice
