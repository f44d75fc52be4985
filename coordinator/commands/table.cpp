#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <iostream>
#include <memory>

#include "coordinator/commands/commands.hpp"
#include "coordinator/commands/output_option.hpp"
#include "coordinator/commands/study_tree.hpp"
#include "coordinator/console/whole_file.hpp"
#include "coordinator/report/state_table.hpp"

namespace coppice {
namespace {

struct TableFlags {
  StudyTreeOption tree;
  OutputOption output;
};

Result<void> table_command(const TableFlags& options) {
  const auto& [path, force] = options.output;
  if (const Result<void> checked = check_output("-o", path, force, options.tree.study); !checked) {
    return checked;
  }
  const Result<StudyTree> given = open_study_tree(options.tree);
  if (!given) {
    return tl::unexpected(given.error());
  }
  const auto& [study, tree] = *given;
  if (!path.empty()) {
    return write_whole_file(path, [&](std::ostream& out) { write_state_table(study.chain(), tree, out); });
  }
  write_state_table(study.chain(), tree, std::cout);
  return {};
}

}  // namespace

void add_table(CLI::App& app, Invocation& invocation) {
  const auto options = std::make_shared<TableFlags>();
  CLI::App* command =
      app.add_subcommand("table", "Print CSV, a row a state: features, visits, the policy's action, the tree's action");
  add_study_tree(*command, options->tree);
  add_output_option(*command, options->output, "Write a file instead of standard output");
  command->footer(
      "Examples:\n"
      "  coppice table uav.coppice > states.csv\n"
      "  coppice table uav.coppice --tree best.tree -o states.csv");
  command->callback([&invocation, options] { invocation.chosen = [options] { return table_command(*options); }; });
}

}  // namespace coppice
