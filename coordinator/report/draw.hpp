// Trees as pictures, by Graphviz (https://graphviz.org): conditions are ellipses, actions are boxes, a sequence is
// labelled with an arrow and a selector with a question mark, as in the figures of the thesis.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "common/error.hpp"
#include "common/tree/tree.hpp"
#include "common/tree/vocabulary.hpp"
#include "coordinator/problem/problem.hpp"

namespace coppice {

// The tree in Graphviz' DOT language, UTF-8. Under a condition or action stands what it says in words, where the
// problem has labels. REQUIRES: check_tree(tree, vocabulary), the problem was made for the vocabulary.
std::string to_dot(const Tree& tree, const Vocabulary& vocabulary, const Problem& problem);

// The format that an extension asks for. Errors name the three that exist.
enum class DrawingFormat : std::uint8_t { dot, svg, png };
Result<DrawingFormat> drawing_format(const std::filesystem::path& path);

// Error: Graphviz' program `dot` is not on PATH.
Result<void> check_dot();

// Writes the drawing in the format of the path's extension; .svg and .png are drawn by Graphviz' program `dot`, found
// on PATH. Errors: an extension that is none of the three (bad_input); `dot` is missing or fails; the file cannot
// be written. The file appears whole or not at all. REQUIRES: as to_dot().
Result<void> write_drawing(const Tree& tree, const Vocabulary& vocabulary, const Problem& problem,
                           const std::filesystem::path& path);

}  // namespace coppice
