#include "coordinator/report/score.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <memory>
#include <optional>

#include "coordinator/commands/commands.hpp"
#include "coordinator/commands/shared_flags.hpp"
#include "coordinator/commands/simulate_option.hpp"
#include "coordinator/commands/study_tree.hpp"
#include "coordinator/commands/whole_number.hpp"
#include "coordinator/runs/simulate_study.hpp"

namespace coppice {
namespace {

struct ScoreFlags {
  StudyTreeOption tree;
  SimulateOption simulate;
  std::uint64_t seen = kSeenVisits;
  bool exact = false;
  bool json = false;
};

Result<void> score_command(const ScoreFlags& options, const StopFlag& stop) {
  const Result<StudyTree> given = open_study_tree(options.tree);
  if (!given) {
    return tl::unexpected(given.error());
  }
  const auto& [study, tree] = *given;
  const Result<World> world = world_of(study, options.simulate.simulator);
  if (!world) {
    return tl::unexpected(world.error());
  }
  SimulateSettings settings = settings_of(options.simulate, study);
  settings.stop = &stop;
  Result<Score> score = score_tree(
      *world, study.chain(), tree, settings, [&] { return !stop.raised(); }, options.seen);
  if (!score) {
    return tl::unexpected(score.error());
  }
  if (const Result<void> kept = keep_simulator(options.tree.study, options.simulate.simulator); !kept) {
    return kept;
  }
  if (options.exact) {
    add_exact(study.chain(), tree, *score);
  }
  if (options.json) {
    fmt::print("{}\n", to_json(*score));
  } else {
    fmt::print("{}", to_text(*score));
  }
  return {};
}

}  // namespace

void add_score(CLI::App& app, Invocation& invocation) {
  const auto options = std::make_shared<ScoreFlags>();
  CLI::App* command = app.add_subcommand("score", "Compare a tree with the learned policy: Table IV of the thesis");
  add_study_tree(*command, options->tree);
  add_simulate_option(*command, options->simulate);
  command->add_option("--seen", options->seen, "Also agreement over the states visited so often or more in learning")
      ->type_name("N")
      ->check(whole_number())
      ->capture_default_str();
  command->add_flag("--exact", options->exact,
                    "Also what is expected along the chain, computed: agreement and reward over --steps steps");
  add_json_flag(*command, options->json);
  command->footer(
      "Examples:\n"
      "  coppice score uav.coppice\n"
      "  coppice score uav.coppice --exact\n"
      "  coppice score uav.coppice --tree '(selector (sequence s3=0 turn_left) move)' --episodes 5000");
  command->callback([&invocation, options] {
    invocation.chosen = [&invocation, options] { return score_command(*options, invocation.stop); };
  });
}

}  // namespace coppice
