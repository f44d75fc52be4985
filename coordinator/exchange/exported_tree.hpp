// What every exporter of trees is given, and the few texts that all of them write: names that fit a language, numbers
// in a feature's own unit, and a legend for whoever reads the file. Values and pure functions.
#pragma once

#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "common/tree/tree.hpp"
#include "common/tree/vocabulary.hpp"
#include "coordinator/problem/problem.hpp"

namespace coppice {

// REQUIRES, of all exporters: check_tree(tree, vocabulary); the problem was made for the vocabulary.
struct ExportedTree {
  const Tree& tree;
  const Vocabulary& vocabulary;
  const Problem& problem;
  std::string origin;  // in words: "uav.coppice, run 1"; may hold any character
};

// The names, each with '_' behind it as often as it takes to be none of `reserved` and unlike the others. Parallel to
// `names`.
std::vector<std::string> identifiers(const std::vector<std::string>& names, const std::set<std::string>& reserved);
std::vector<std::string> feature_names(const Vocabulary& vocabulary);

// What a reading in the feature's own unit is compared with: "3", "-0.25". The last bin has no upper edge; then it is
// the largest number there is, so that "reading <= this" always holds. REQUIRES: one of the feature's values.
std::string compared_number(const Feature& feature, std::uint8_t value);

// On one line, whatever was given: control characters become blanks, and a backslash becomes a slash, so that the text
// can stand in a line comment of any language.
std::string one_line(std::string_view text);

// Lines about the file: where the tree comes from, then each feature and action that it names and that has a label:
//   tree of uav.coppice, run 1: 18 nodes
//   s3: ahead (0 wall, 1 free, 3 trash)
std::vector<std::string> header_lines(const ExportedTree& exported);

}  // namespace coppice
