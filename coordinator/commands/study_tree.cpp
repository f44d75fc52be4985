#include "coordinator/commands/study_tree.hpp"

#include <CLI/CLI.hpp>
#include <cerrno>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <system_error>
#include <vector>

#include "common/tree/text.hpp"
#include "coordinator/commands/tree_lines.hpp"
#include "coordinator/commands/whole_number.hpp"

namespace coppice {
namespace {

Result<Tree> tree_in_file(const std::string& path, const Vocabulary& vocabulary) {
  std::filebuf in;
  if (in.open(path, std::ios::in) == nullptr) {
    return failed(fmt::format("cannot read {}: {}", path, std::generic_category().message(errno)));
  }
  TreeLines lines(in, path, vocabulary);
  std::optional<Tree> tree;
  // Ends with the file: every turn consumes a line.
  while (true) {
    const Result<TreeLines::Event> event = lines.next();
    if (!event) {
      return tl::unexpected(event.error());
    }
    if (*event == TreeLines::Event::end) {
      break;
    }
    if (*event == TreeLines::Event::tree) {
      if (tree) {
        return bad_input(fmt::format("{}: holds more than one tree: expected one", path));
      }
      tree = lines.tree();
    }
  }
  if (!tree) {
    return bad_input(fmt::format("{}: holds no tree: expected one", path));
  }
  return *tree;
}

Result<Tree> tree_of_last_run(const Study& study) {
  const Result<std::vector<RunRecord>> runs = study.runs();
  if (!runs) {
    return tl::unexpected(runs.error());
  }
  for (auto run = runs->rbegin(); run != runs->rend(); ++run) {
    if (run->status == RunStatus::finished) {
      return study.best_tree(run->id);
    }
  }
  for (auto run = runs->rbegin(); run != runs->rend(); ++run) {
    if (run->tree || run->generations > 0) {
      return study.best_tree(run->id);
    }
  }
  return bad_input(
      fmt::format("{}: has no run with a tree yet: expected --tree, or run 'coppice evolve' first", study.path()));
}

Result<Tree> tree_of(const StudyTreeOption& option, const Study& study) {
  if (option.run) {
    return study.best_tree(RunId{*option.run});
  }
  if (option.tree.empty()) {
    return tree_of_last_run(study);
  }
  std::error_code error;  // a long tree is no valid file name: not a file, then
  if (std::filesystem::is_regular_file(option.tree, error)) {
    return tree_in_file(option.tree, study.chain().vocabulary());
  }
  Result<Tree> tree = parse_tree(option.tree, study.chain().vocabulary());
  if (!tree) {
    return in_context("--tree (no file of that name, so read as a tree)", std::move(tree).error());
  }
  return tree;
}

}  // namespace

void add_study_tree(CLI::App& command, StudyTreeOption& option) {
  command.add_option("STUDY", option.study, "The study file")->required();
  CLI::Option* tree = command.add_option("--tree", option.tree,
                                         "The tree: its text form, or a file that holds one (default: the best "
                                         "tree of the last finished run)");
  tree->type_name("TEXT|FILE");
  command.add_option("--run", option.run, "The best tree of this run instead")
      ->type_name("N")
      ->check(whole_number())
      ->excludes(tree);
}

Result<StudyTree> open_study_tree(const StudyTreeOption& option) {
  Result<Study> study = Study::open(option.study, Study::Access::read);
  if (!study) {
    return tl::unexpected(std::move(study).error());
  }
  Result<Tree> tree = tree_of(option, *study);
  if (!tree) {
    return tl::unexpected(std::move(tree).error());
  }
  return StudyTree{std::move(*study), std::move(*tree)};
}

}  // namespace coppice
