#include "coordinator/commands/simulate_option.hpp"

#include <CLI/CLI.hpp>

#include "coordinator/commands/learn_options.hpp"
#include "coordinator/commands/whole_number.hpp"
#include "coordinator/report/score.hpp"

namespace coppice {

void add_simulate_option(CLI::App& command, SimulateOption& option, const SimulateHelp& help) {
  command.add_option("--episodes", option.episodes, help.episodes)->check(whole_number())->capture_default_str();
  command.add_option("--steps", option.steps, "Steps per episode (default: as in learning)")->check(whole_number());
  command.add_option("--seed", option.seed, help.seed)->check(whole_number())->capture_default_str();
}

SimulateSettings settings_of(const SimulateOption& option, const Study& study) {
  return {
      .episodes = option.episodes, .steps = option.steps ? *option.steps : learned_steps(study), .seed = option.seed};
}

Result<World> world_of(const Study& study) {
  Result<World> world = make_world(study.world().kind, study.world().room);
  if (!world) {
    return in_context(study.path(), std::move(world).error());
  }
  return world;
}

Result<std::optional<std::vector<EpisodeRecord>>> simulated(const Study& study, const Tree& tree,
                                                            const SimulateSettings& settings, const StopFlag& stop) {
  using Episodes = std::optional<std::vector<EpisodeRecord>>;
  if (study.world().kind == kNoWorld) {
    return Episodes();
  }
  const Result<World> world = world_of(study);
  if (!world) {
    return tl::unexpected(world.error());
  }
  if (const Result<void> checked = check_score_settings(settings); !checked) {
    return tl::unexpected(checked.error());
  }
  return simulate_tree(*world, study.chain(), tree, settings, [&] { return !stop.raised(); })
      .map([](std::vector<EpisodeRecord> episodes) { return Episodes(std::move(episodes)); });
}

}  // namespace coppice
