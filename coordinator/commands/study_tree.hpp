// STUDY, --tree TEXT|FILE and --run N: which tree of which study a command is about.
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

struct StudyTreeOption {
  std::string study;
  std::string tree;                 // text or file; empty: the best tree of a run
  std::optional<std::int64_t> run;  // empty: the last finished run, else the last that has a tree
};

void add_study_tree(CLI::App& command, StudyTreeOption& option);

// The tree of an open study. Errors (bad_input): malformed text, naming file, line and column; a file that does not
// hold exactly one tree (as text, JSON or XML of BehaviorTree.CPP); a study without such a run.
Result<Tree> study_tree(const StudyTreeOption& option, const Study& study);

struct StudyTree {
  Study study;  // to read
  Tree tree;
};

// Errors: as Study::open() and study_tree().
Result<StudyTree> open_study_tree(const StudyTreeOption& option);

// Prints what the tree's features and actions mean, a line each behind an empty one; nothing where there are no labels.
void print_legend(const Tree& tree, const Study& study);

}  // namespace coppice
