// --episodes, --steps, --seed and --simulator.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "coordinator/learning/simulate.hpp"
#include "coordinator/study/study.hpp"

namespace CLI {
class App;
}

namespace coppice {

struct SimulateOption {
  std::uint64_t episodes = SimulateSettings{}.episodes;
  std::optional<std::uint32_t> steps = {};  // empty: as in learning
  std::uint64_t seed = SimulateSettings{}.seed;
  std::string simulator = {};  // a command; empty: what the study has
};

struct SimulateHelp {
  const char* episodes = "Episodes in the simulator; 500 or more for narrow intervals";
  const char* seed = "Seed of the simulator";
};
void add_simulate_option(CLI::App& command, SimulateOption& option, const SimulateHelp& help = {});

// --simulator COMMAND alone.
void add_simulator(CLI::App& command, std::string& simulator);

SimulateSettings settings_of(const SimulateOption& option, const Study& study);

}  // namespace coppice
