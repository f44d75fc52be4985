// A tree as a LaTeX document that draws it with TikZ (package forest): pdflatex makes a page of the drawing's size, and
// the `forest` environment can be copied into a paper.
#pragma once

#include <string>

#include "coordinator/exchange/exported_tree.hpp"

namespace coppice {

std::string to_tikz(const ExportedTree& exported);

}  // namespace coppice
