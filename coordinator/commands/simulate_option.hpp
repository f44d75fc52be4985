// --episodes, --steps and --seed of the simulator, and a tree in the simulator of a study's world.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/error.hpp"
#include "common/stop.hpp"
#include "common/tree/tree.hpp"
#include "coordinator/learning/simulate.hpp"
#include "coordinator/study/study.hpp"

namespace CLI {
class App;
}

namespace coppice {

struct SimulateOption {
  std::uint64_t episodes = SimulateSettings{}.episodes;
  std::optional<std::uint32_t> steps;  // empty: as in learning
  std::uint64_t seed = SimulateSettings{}.seed;
};

struct SimulateHelp {
  const char* episodes = "Episodes in the simulator; 500 or more for narrow intervals";
  const char* seed = "Of the simulator";
};
void add_simulate_option(CLI::App& command, SimulateOption& option, const SimulateHelp& help = {});

SimulateSettings settings_of(const SimulateOption& option, const Study& study);

// Errors: the study has no world.
Result<World> world_of(const Study& study);

// Nothing where the study has no world. Errors name the flag, as check_score_settings(); interrupted.
Result<std::optional<std::vector<EpisodeRecord>>> simulated(const Study& study, const Tree& tree,
                                                            const SimulateSettings& settings, const StopFlag& stop);

}  // namespace coppice
