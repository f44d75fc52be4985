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

Result<std::optional<std::vector<std::vector<EpisodeRecord>>>> simulated_all(
    const Study& study, std::span<const Tree> trees, const SimulateSettings& settings, const std::string& simulator,
    const StopFlag& stop, const std::function<void(std::size_t)>& done) {
  using OfTrees = std::optional<std::vector<std::vector<EpisodeRecord>>>;
  if (simulator.empty() && !has_simulator(study)) {
    return OfTrees();
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
  return simulate_trees(
             *world, study.chain(), trees, stopped_by, [&] { return !stop.raised(); }, done)
      .map([](std::vector<std::vector<EpisodeRecord>> all) { return OfTrees(std::move(all)); });
}

Result<std::optional<std::vector<EpisodeRecord>>> simulated(const Study& study, const Tree& tree,
                                                            const SimulateSettings& settings,
                                                            const std::string& simulator, const StopFlag& stop) {
  return simulated_all(study, std::span(&tree, 1), settings, simulator, stop, {}).map([](auto all) {
    return all ? std::optional(std::move(all->front())) : std::nullopt;
  });
}

}  // namespace coppice
