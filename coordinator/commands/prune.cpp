#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/tree/guard.hpp"
#include "common/tree/simplify.hpp"
#include "common/tree/state_columns.hpp"
#include "common/tree/text.hpp"
#include "coordinator/commands/commands.hpp"
#include "coordinator/commands/shared_flags.hpp"
#include "coordinator/commands/study_tree.hpp"
#include "coordinator/console/counted.hpp"
#include "coordinator/console/json_line.hpp"

namespace coppice {
namespace {

struct PruneFlags {
  StudyTreeOption tree;
  bool sound = false;
  bool guarded = false;
  bool json = false;
};

Result<void> prune_command(const PruneFlags& options) {
  const Result<StudyTree> given = open_study_tree(options.tree);
  if (!given) {
    return tl::unexpected(given.error());
  }
  const auto& [study, tree] = *given;
  const Vocabulary& vocabulary = study.chain().vocabulary();
  const auto prune = [&](const Tree& whole) {
    return options.sound ? simplify(whole, vocabulary)
                         : simplify(whole, vocabulary, StateColumns(vocabulary, study.chain().parts().features));
  };
  const Simplified pruned = prune(tree);
  std::optional<Tree> guarded;
  if (options.guarded) {
    Result<Tree> form = guard(pruned.tree, vocabulary);
    if (!form) {
      return in_context("--guarded", std::move(form).error());
    }
    guarded = prune(*form).tree;
  }
  if (options.json) {
    nlohmann::ordered_json removals = nlohmann::ordered_json::array();
    for (const Removal& removal : pruned.removals) {
      removals.push_back({{"what", removal.what}, {"reason", removal.reason}, {"nodes", removal.nodes}});
    }
    nlohmann::ordered_json json = {{"tree", to_text(tree, vocabulary)},
                                   {"nodes", tree.size()},
                                   {"pruned", to_text(pruned.tree, vocabulary)},
                                   {"pruned_nodes", pruned.tree.size()},
                                   {"holds", options.sound ? "every state" : "states of the chain"},
                                   {"removals", removals}};
    if (guarded) {
      json["guarded"] = to_text(*guarded, vocabulary);
      json["guarded_nodes"] = guarded->size();
    }
    fmt::print("{}\n", json_line(json));
    return {};
  }
  for (const Removal& removal : pruned.removals) {
    fmt::print("-{} {}: {}\n", removal.nodes, removal.what, removal.reason);
  }
  fmt::print("{}, pruned to {}, the same action in every state{}:\n{}\n", counted(tree.size(), "node"),
             pruned.tree.size(), options.sound ? "" : " of the chain", to_text(pruned.tree, vocabulary));
  if (guarded) {
    fmt::print("in guarded form, which asks before it acts, {}:\n{}\n", counted(guarded->size(), "node"),
               to_text(*guarded, vocabulary));
  }
  return {};
}

}  // namespace

void add_prune(CLI::App& app, Invocation& invocation) {
  const auto options = std::make_shared<PruneFlags>();
  CLI::App* command = app.add_subcommand("prune", "Remove what changes no action, and say why for every node");
  add_study_tree(*command, options->tree);
  command->add_flag("--sound", options->sound,
                    "Only what changes no action in any state, whether the chain has seen it or not");
  command->add_flag("--guarded", options->guarded,
                    "Also the pruned tree in guarded form: every sequence asks before it acts, as a robot that acts at "
                    "once needs it; the same action in every state");
  add_json_flag(*command, options->json);
  command->footer(
      "Each line is a removal: how many nodes, what went, and why. The last line is the pruned tree (--guarded: its\n"
      "guarded form).\n"
      "Examples:\n"
      "  coppice prune uav.coppice\n"
      "  coppice prune uav.coppice --tree '(selector move (sequence s3=0 turn_left))' --sound\n"
      "  coppice prune uav.coppice --tree '(sequence move s3=0 turn_left)' --guarded");
  command->callback([&invocation, options] { invocation.chosen = [options] { return prune_command(*options); }; });
}

}  // namespace coppice
