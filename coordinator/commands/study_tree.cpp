#include "coordinator/commands/study_tree.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <vector>

#include "coordinator/commands/shared_flags.hpp"
#include "coordinator/console/printable.hpp"
#include "coordinator/problem/legend.hpp"
#include "coordinator/runs/tree_of_study.hpp"

namespace coppice {

void add_study_tree(CLI::App& command, StudyTreeOption& option) {
  add_study_argument(command, option.study);
  CLI::Option* tree = command.add_option("--tree", option.tree,
                                         "The tree: its text form, or a file that holds one, also as JSON or XML "
                                         "of BehaviorTree.CPP (default: the best tree of the last finished run)");
  tree->type_name("TEXT|FILE");
  add_run_option(command, option.run, "The best tree of this run instead")->excludes(tree);
}

Result<Tree> study_tree(const StudyTreeOption& option, const Study& study) {
  const std::optional<RunId> run = option.run ? std::optional(RunId{*option.run}) : std::nullopt;
  return option.tree.empty() ? tree_of_run(study, run) : tree_of_text_or_file(study, option.tree);
}

void print_legend(const Tree& tree, const Study& study) {
  const std::vector<std::string> lines = legend_lines(tree, study.problem(), study.chain().vocabulary());
  for (std::size_t i = 0; i < lines.size(); ++i) {
    fmt::print("{}{}\n", i == 0 ? "\n" : "", printable(lines[i]));
  }
}

Result<StudyTree> open_study_tree(const StudyTreeOption& option) {
  Result<Study> study = Study::open(option.study, Study::Access::read);
  if (!study) {
    return tl::unexpected(std::move(study).error());
  }
  Result<Tree> tree = study_tree(option, *study);
  if (!tree) {
    return tl::unexpected(std::move(tree).error());
  }
  return StudyTree{std::move(*study), std::move(*tree)};
}

}  // namespace coppice
