#include "coordinator/trust/edit.hpp"

#include <CLI/CLI.hpp>
#include <array>
#include <fmt/format.h>
#include <memory>
#include <optional>
#include <utility>

#include "common/tree/text.hpp"
#include "coordinator/commands/commands.hpp"
#include "coordinator/commands/output_option.hpp"
#include "coordinator/commands/shared_flags.hpp"
#include "coordinator/commands/simulate_option.hpp"
#include "coordinator/commands/study_tree.hpp"
#include "coordinator/console/json_line.hpp"
#include "coordinator/console/whole_file.hpp"
#include "coordinator/report/score.hpp"
#include "coordinator/runs/simulate_study.hpp"
#include "coordinator/trust/tree_figures.hpp"
#include "coordinator/trust/verification_report.hpp"

namespace coppice {
namespace {

using Json = nlohmann::ordered_json;

struct EditFlags {
  StudyTreeOption tree;
  std::vector<std::string> replacements;
  std::vector<std::string> insertions;
  std::vector<std::string> deletions;
  OutputOption output;
  SimulateOption simulate;
  bool json = false;
};

Result<std::vector<TreeEdit>> edits_of(const EditFlags& options, const Vocabulary& vocabulary) {
  using Kind = TreeEdit::Kind;
  const std::array<std::tuple<const char*, Kind, const std::vector<std::string>*>, 3> given = {
      {{"--replace", Kind::replace, &options.replacements},
       {"--insert", Kind::insert, &options.insertions},
       {"--delete", Kind::remove, &options.deletions}}};
  std::vector<TreeEdit> edits;
  for (const auto& [flag, kind, texts] : given) {
    for (const std::string& text : *texts) {
      Result<TreeEdit> edit = parse_edit(kind, text, vocabulary);
      if (!edit) {
        return in_context(fmt::format("{} '{}'", flag, text), std::move(edit).error());
      }
      edits.push_back(std::move(*edit));
    }
  }
  return edits;
}

Result<TreeFigures> scored(const Tree& tree, const Study& study, const SimulateSettings& settings,
                           const std::string& simulator, const StopFlag& stop) {
  TreeFigures figures = figures_of(study.chain(), tree, settings.steps);
  const auto episodes = simulated(study, tree, settings, simulator, stop);
  if (!episodes) {
    return tl::unexpected(episodes.error());
  }
  if (*episodes) {
    figures.simulated = controller_score(**episodes);
  }
  return figures;
}

Json json_of(const Tree& tree, const TreeFigures& figures, const Vocabulary& vocabulary) {
  Json json = {{"tree", to_text(tree, vocabulary)},
               {"nodes", figures.nodes},
               {"agreement_over_states", figures.coverage()},
               {"agreement_along_chain", figures.along_chain.agreement},
               {"reward_along_chain", figures.along_chain.reward}};
  if (figures.simulated) {
    const ControllerScore& score = *figures.simulated;
    json["agreement_in_simulation"] = {{"mean", score.agreement.mean}, {"margin", score.agreement.margin}};
    json["reward_in_simulation"] = {{"mean", score.reward.mean}, {"margin", score.reward.margin}};
    json["collisions"] = score.total_collisions;
  }
  return json;
}

Result<void> edit_command(const EditFlags& options, const StopFlag& stop) {
  const auto& [path, force] = options.output;
  if (const Result<void> checked = check_output("-o", path, force, options.tree.study); !checked) {
    return checked;
  }
  const Result<StudyTree> given = open_study_tree(options.tree);
  if (!given) {
    return tl::unexpected(given.error());
  }
  const auto& [study, tree] = *given;
  const Vocabulary& vocabulary = study.chain().vocabulary();
  const Result<std::vector<TreeEdit>> edits = edits_of(options, vocabulary);
  if (!edits) {
    return tl::unexpected(edits.error());
  }
  const Result<Tree> edited = apply_edits(tree, *edits);
  if (!edited) {
    return tl::unexpected(edited.error());
  }
  const SimulateSettings settings = settings_of(options.simulate, study);
  if (const Result<void> checked = check_score_settings(settings); !checked) {
    return checked;
  }
  const Result<TreeFigures> before = scored(tree, study, settings, options.simulate.simulator, stop);
  if (!before) {
    return tl::unexpected(before.error());
  }
  const Result<TreeFigures> after =
      edits->empty() ? before : scored(*edited, study, settings, options.simulate.simulator, stop);
  if (!after) {
    return tl::unexpected(after.error());
  }
  if (!path.empty()) {
    if (const auto written = write_whole_file(path, to_text(*edited, vocabulary) + "\n"); !written) {
      return written;
    }
  }
  if (options.json) {
    const Json json = {{"before", json_of(tree, *before, vocabulary)}, {"after", json_of(*edited, *after, vocabulary)}};
    fmt::print("{}\n", json_line(json));
    return {};
  }
  if (edits->empty()) {
    fmt::print("{}\n{}", numbered(tree, vocabulary, study.problem()), side_by_side({"now"}, {*before}));
    return {};
  }
  fmt::print("before:\n{}\nafter:\n{}\n{}{}\n", numbered(tree, vocabulary, study.problem()),
             numbered(*edited, vocabulary, study.problem()), side_by_side({"before", "after"}, {*before, *after}),
             to_text(*edited, vocabulary));
  return {};
}

}  // namespace

void add_edit(CLI::App& app, Invocation& invocation) {
  const auto options = std::make_shared<EditFlags>();
  CLI::App* command = app.add_subcommand("edit", "Change a tree by hand, and see its scores before and after");
  add_study_tree(*command, options->tree);
  const auto add_change = [&](const char* flag, std::vector<std::string>& into, const char* help, const char* type) {
    command->add_option(flag, into, help)->type_name(type)->allow_extra_args(false);
  };
  add_change("--replace", options->replacements, "Replace node N; may be repeated", "'N SUBTREE'");
  add_change("--insert", options->insertions,
             "Insert a child into node N, in front of its child number P; may be repeated", "'N P SUBTREE'");
  add_change("--delete", options->deletions, "Delete node N and what is under it; may be repeated", "N");
  add_output_option(*command, options->output, "Write the tree to this file");
  add_simulate_option(*command, options->simulate);
  add_json_flag(*command, options->json);
  command->footer(
      "Nodes are numbered as shown, from 0 for the root; children from 0. All numbers are those of the tree before\n"
      "any change. Without a change: the numbered tree and its scores.\n"
      "Examples:\n"
      "  coppice edit uav.coppice\n"
      "  coppice edit uav.coppice --insert '0 0 (sequence s5=3 turn_right)' -o better.tree\n"
      "  coppice edit uav.coppice --tree better.tree --replace '3 s1=0' --delete 7");
  command->callback([&invocation, options] {
    invocation.chosen = [&invocation, options] { return edit_command(*options, invocation.stop); };
  });
}

}  // namespace coppice
