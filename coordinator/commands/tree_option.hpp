// --tree TEXT|FILE and --run N: which tree a command is about.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "common/error.hpp"
#include "common/tree/tree.hpp"
#include "coordinator/study/study.hpp"

namespace CLI {
class App;
}

namespace coppice {

struct TreeOption {
  std::string tree;                 // text or file; empty: the best tree of a run
  std::optional<std::int64_t> run;  // empty: the last finished run, else the last that has a tree
};

void add_tree_option(CLI::App& command, TreeOption& option);

// Errors (bad_input): malformed text, naming file, line and column; a file that does not hold exactly one tree; a study
// without such a run.
Result<Tree> tree_of(const TreeOption& option, const Study& study);

}  // namespace coppice
