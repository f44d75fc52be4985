#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <memory>
#include <nlohmann/json.hpp>

#include "common/tree/simplify.hpp"
#include "common/tree/state_columns.hpp"
#include "common/tree/text.hpp"
#include "coordinator/commands/commands.hpp"
#include "coordinator/commands/study_tree.hpp"
#include "coordinator/report/counted.hpp"
#include "coordinator/report/json_line.hpp"

namespace coppice {
namespace {

struct Options {
  StudyTreeOption tree;
  bool sound = false;
  bool json = false;
};

Result<void> prune_command(const Options& options) {
  const Result<StudyTree> given = open_study_tree(options.tree);
  if (!given) {
    return tl::unexpected(given.error());
  }
  const auto& [study, tree] = *given;
  const Vocabulary& vocabulary = study.chain().vocabulary();
  const Simplified pruned = options.sound
                                ? simplify(tree, vocabulary)
                                : simplify(tree, vocabulary, StateColumns(vocabulary, study.chain().parts().features));
  if (options.json) {
    nlohmann::ordered_json removals = nlohmann::ordered_json::array();
    for (const Removal& removal : pruned.removals) {
      removals.push_back({{"what", removal.what}, {"reason", removal.reason}, {"nodes", removal.nodes}});
    }
    const nlohmann::ordered_json json = {{"tree", to_text(tree, vocabulary)},
                                         {"nodes", tree.size()},
                                         {"pruned", to_text(pruned.tree, vocabulary)},
                                         {"pruned_nodes", pruned.tree.size()},
                                         {"holds", options.sound ? "every state" : "states of the chain"},
                                         {"removals", removals}};
    fmt::print("{}\n", json_line(json));
    return {};
  }
  for (const Removal& removal : pruned.removals) {
    fmt::print("-{} {}: {}\n", removal.nodes, removal.what, removal.reason);
  }
  fmt::print("{}, pruned to {}, the same action in every state{}:\n{}\n", counted(tree.size(), "node"),
             pruned.tree.size(), options.sound ? "" : " of the chain", to_text(pruned.tree, vocabulary));
  return {};
}

}  // namespace

void add_prune(CLI::App& app, Invocation& invocation) {
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("prune", "Remove what changes no action, and say why for every node");
  add_study_tree(*command, options->tree);
  command->add_flag("--sound", options->sound,
                    "Only what changes no action in any state, whether the chain has seen it or not");
  command->add_flag("--json", options->json, "Report as one JSON object");
  command->footer(
      "Each line is a removal: how many nodes, what went, and why. The last line is the pruned tree.\n"
      "Examples:\n"
      "  coppice prune uav.coppice\n"
      "  coppice prune uav.coppice --tree '(selector move (sequence s3=0 turn_left))' --sound");
  command->callback([&invocation, options] { invocation.chosen = [options] { return prune_command(*options); }; });
}

}  // namespace coppice
