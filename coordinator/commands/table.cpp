#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <iostream>
#include <memory>

#include "coordinator/commands/commands.hpp"
#include "coordinator/commands/tree_option.hpp"
#include "coordinator/report/state_table.hpp"
#include "coordinator/report/whole_file.hpp"

namespace coppice {
namespace {

struct Options {
  std::string study;
  TreeOption tree;
  std::string output;
};

Result<void> table_command(const Options& options) {
  const Result<Study> study = Study::open(options.study, Study::Access::read);
  if (!study) {
    return tl::unexpected(study.error());
  }
  if (const Result<void> other = check_other_file("-o", options.output, options.study); !other) {
    return other;
  }
  const Result<Tree> tree = tree_of(options.tree, *study);
  if (!tree) {
    return tl::unexpected(tree.error());
  }
  if (!options.output.empty()) {
    return write_whole_file(options.output, [&](std::ostream& out) { write_state_table(study->chain(), *tree, out); });
  }
  write_state_table(study->chain(), *tree, std::cout);
  return {};
}

}  // namespace

void add_table(CLI::App& app, Invocation& invocation) {
  const auto options = std::make_shared<Options>();
  CLI::App* command =
      app.add_subcommand("table", "Print CSV, a row a state: features, visits, the policy's action, the tree's action");
  command->add_option("STUDY", options->study, "The study file")->required();
  add_tree_option(*command, options->tree);
  command->add_option("-o,--output", options->output, "Write a file instead of standard output")->type_name("FILE");
  command->footer(
      "Examples:\n"
      "  coppice table uav.coppice > states.csv\n"
      "  coppice table uav.coppice --tree best.tree -o states.csv");
  command->callback([&invocation, options] { invocation.chosen = [options] { return table_command(*options); }; });
}

}  // namespace coppice
