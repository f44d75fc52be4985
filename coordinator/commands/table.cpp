#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <iostream>
#include <memory>

#include "coordinator/commands/commands.hpp"
#include "coordinator/commands/study_tree.hpp"
#include "coordinator/report/state_table.hpp"
#include "coordinator/report/whole_file.hpp"

namespace coppice {
namespace {

struct Options {
  StudyTreeOption tree;
  std::string output;
};

Result<void> table_command(const Options& options) {
  const Result<StudyTree> given = open_study_tree(options.tree);
  if (!given) {
    return tl::unexpected(given.error());
  }
  const auto& [study, tree] = *given;
  if (const Result<void> other = check_other_file("-o", options.output, options.tree.study); !other) {
    return other;
  }
  if (!options.output.empty()) {
    return write_whole_file(options.output, [&](std::ostream& out) { write_state_table(study.chain(), tree, out); });
  }
  write_state_table(study.chain(), tree, std::cout);
  return {};
}

}  // namespace

void add_table(CLI::App& app, Invocation& invocation) {
  const auto options = std::make_shared<Options>();
  CLI::App* command =
      app.add_subcommand("table", "Print CSV, a row a state: features, visits, the policy's action, the tree's action");
  add_study_tree(*command, options->tree);
  command->add_option("-o,--output", options->output, "Write a file instead of standard output")->type_name("FILE");
  command->footer(
      "Examples:\n"
      "  coppice table uav.coppice > states.csv\n"
      "  coppice table uav.coppice --tree best.tree -o states.csv");
  command->callback([&invocation, options] { invocation.chosen = [options] { return table_command(*options); }; });
}

}  // namespace coppice
