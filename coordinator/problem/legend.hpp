// What the names in a tree mean, a line each, for whoever reads the tree: a legend from a problem's labels. Pure.
#pragma once

#include <string>
#include <vector>

#include "common/tree/tree.hpp"
#include "coordinator/problem/problem.hpp"

namespace coppice {

// "s3: ahead (0 wall, 1 free, 3 trash)", "pole_angle: angle of the pole [rad]". Empty: it has no label, unit or
// labelled value. REQUIRES (all): the problem was made for the vocabulary.
std::string feature_legend(std::size_t feature, const Problem& problem, const Vocabulary& vocabulary);

// "turn_left: turn to the left". Empty: it has no label.
std::string action_legend(std::size_t action, const Problem& problem, const Vocabulary& vocabulary);

// Of the features and actions that the tree names, in the vocabulary's order. REQUIRES: check_tree().
std::vector<std::string> legend_lines(const Tree& tree, const Problem& problem, const Vocabulary& vocabulary);

}  // namespace coppice
