// A population as a study keeps it: one individual a line, "fitness TAB tree", by slot. Readable with the sqlite3
// program; fitness has as many digits as it takes to read back the same bits.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/error.hpp"
#include "common/tree/tree.hpp"

namespace coppice {

struct FitTrees {
  std::vector<Tree> trees;
  std::vector<double> fitness;
};

// REQUIRES: one fitness per tree, check_tree() for each.
std::string population_text(const FitTrees& population, const Vocabulary& vocabulary);

// Errors name the line and what was expected.
Result<FitTrees> population_from_text(std::string_view text, const Vocabulary& vocabulary);

}  // namespace coppice
