#include "coordinator/runs/simulate_study.hpp"

#include <fmt/format.h>
#include <utility>

#include "coordinator/report/score.hpp"

namespace coppice {

bool has_simulator(const Study& study) { return study.world().kind != kNoWorld || !study.problem().simulator.empty(); }

Result<World> world_of(const Study& study, const std::string& simulator) {
  const std::string& command = simulator.empty() ? study.problem().simulator : simulator;
  if (command.size() > kMaxSimulatorCommand) {
    return bad_input(
        fmt::format("--simulator has {} characters: expected at most {}", command.size(), kMaxSimulatorCommand));
  }
  if (!command.empty()) {
    return outside_world(command, study.chain().vocabulary());
  }
  Result<World> world = make_world(study.world().kind, study.world().room);
  if (!world) {
    return in_context(study.path(), std::move(world).error());
  }
  return world;
}

Result<void> keep_simulator(const std::string& study_path, const std::string& simulator) {
  if (simulator.empty()) {
    return {};
  }
  Result<Study> study = Study::open(study_path);
  if (!study) {
    return tl::unexpected(std::move(study).error());
  }
  if (study->problem().simulator == simulator) {
    return {};
  }
  return study->change_problem([&](Problem& problem) -> Result<void> {
    problem.simulator = simulator;
    return {};
  });
}

Result<std::optional<std::vector<EpisodeRecord>>> simulated(const Study& study, const Tree& tree,
                                                            const SimulateSettings& settings,
                                                            const std::string& simulator, const StopFlag& stop) {
  using Episodes = std::optional<std::vector<EpisodeRecord>>;
  if (simulator.empty() && !has_simulator(study)) {
    return Episodes();
  }
  const Result<World> world = world_of(study, simulator);
  if (!world) {
    return tl::unexpected(world.error());
  }
  if (const Result<void> checked = check_score_settings(settings); !checked) {
    return tl::unexpected(checked.error());
  }
  SimulateSettings stopped_by = settings;
  stopped_by.stop = &stop;
  return simulate_tree(*world, study.chain(), tree, stopped_by, [&] { return !stop.raised(); })
      .map([](std::vector<EpisodeRecord> episodes) { return Episodes(std::move(episodes)); });
}

}  // namespace coppice
