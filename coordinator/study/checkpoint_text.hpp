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

// The archives of a run's demes one behind the other, each closed by an empty line, or that of its only deme, which is
// not.
struct KeptTrees {
  std::vector<Tree> trees;
  std::vector<std::size_t> kept;  // [demes], how many of the trees are each one's; empty: all are the only deme's
};
// REQUIRES: kept is empty or sums to the number of trees, check_tree() for each.
std::string archives_text(const KeptTrees& archives, const Vocabulary& vocabulary);
Result<KeptTrees> archives_from_text(std::string_view text, const Vocabulary& vocabulary);

}  // namespace coppice
