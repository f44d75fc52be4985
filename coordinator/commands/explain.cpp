#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <memory>
#include <optional>

#include "coordinator/commands/commands.hpp"
#include "coordinator/commands/learn_options.hpp"
#include "coordinator/commands/shared_flags.hpp"
#include "coordinator/commands/study_tree.hpp"
#include "coordinator/commands/whole_number.hpp"
#include "coordinator/console/json_line.hpp"
#include "coordinator/runs/simulate_study.hpp"
#include "coordinator/trust/explanation_report.hpp"

namespace coppice {
namespace {

struct ExplainFlags {
  StudyTreeOption tree;
  std::string weights = std::string(name_of(Weighting::tree));
  std::optional<std::uint32_t> steps;
  std::uint32_t tests = ExplainSettings{}.tests;
  std::uint32_t groups = ExplainSettings{}.groups;
  std::uint64_t most_states = 10;
  bool json = false;
};

Result<void> explain_command(const ExplainFlags& options) {
  const Result<StudyTree> given = open_study_tree(options.tree);
  if (!given) {
    return tl::unexpected(given.error());
  }
  const auto& [study, tree] = *given;
  const Result<Weighting> weighting = value_named<Weighting>("weighting", options.weights);
  if (!weighting) {
    return in_context("--weights", weighting.error());
  }
  const ExplainSettings settings{.weighting = *weighting,
                                 .steps = options.steps ? *options.steps : learned_steps(study),
                                 .tests = options.tests,
                                 .groups = options.groups};
  if (const Result<void> checked = check_settings(settings); !checked) {
    return checked;
  }
  const ExplainReport report = explain_report(study.chain(), tree, settings);
  if (options.json) {
    fmt::print("{}\n", json_line(to_json(report, study.chain(), tree, options.most_states)));
  } else {
    fmt::print("{}", to_text(report, study.chain(), tree, study.problem(), options.most_states));
    print_legend(tree, study);
  }
  return {};
}

}  // namespace

void add_explain(CLI::App& app, Invocation& invocation) {
  const auto options = std::make_shared<ExplainFlags>();
  CLI::App* command =
      app.add_subcommand("explain", "Where tree and policy differ, what it costs, and which branch to add next");
  add_study_tree(*command, options->tree);
  command
      ->add_option(
          "--weights", options->weights,
          "How much a state counts: as often as the tree visits it, or the policy, or learning did; or all the same")
      ->type_name("tree|policy|learning|states")
      ->capture_default_str();
  command->add_option("--steps", options->steps, "Steps per episode (default: as in learning)")->check(whole_number());
  command->add_option("--tests", options->tests, "Tests in a branch, at most")
      ->check(whole_number())
      ->capture_default_str();
  command->add_option("--groups", options->groups, "Branches to suggest, at most")
      ->check(whole_number())
      ->capture_default_str();
  command->add_option("--states", options->most_states, "How many of the costliest states to list")
      ->check(whole_number())
      ->capture_default_str();
  add_json_flag(*command, options->json);
  command->footer(
      "Each suggestion is what 'coppice edit' takes.\n"
      "Examples:\n"
      "  coppice explain uav.coppice\n"
      "  coppice explain uav.coppice --tree best.tree --weights states --tests 2");
  command->callback([&invocation, options] { invocation.chosen = [options] { return explain_command(*options); }; });
}

}  // namespace coppice
