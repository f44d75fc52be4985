#include "coordinator/commands/simulate_option.hpp"

#include <CLI/CLI.hpp>

#include "coordinator/commands/shared_flags.hpp"
#include "coordinator/commands/whole_number.hpp"
#include "coordinator/runs/learn_study.hpp"

namespace coppice {

void add_simulate_option(CLI::App& command, SimulateOption& option, const SimulateHelp& help) {
  command.add_option("--episodes", option.episodes, help.episodes)->check(whole_number())->capture_default_str();
  command.add_option("--steps", option.steps, "Steps per episode (default: as in learning)")->check(whole_number());
  add_seed_option(command, option.seed, help.seed);
  add_simulator(command, option.simulator);
}

void add_simulator(CLI::App& command, std::string& simulator) {
  command
      .add_option("--simulator", simulator,
                  "The problem's own simulator, a shell command that speaks JSON lines, instead of our world; kept in "
                  "the study (for Gymnasium: python -m coppice.gym ENV)")
      ->type_name("COMMAND");
}

SimulateSettings settings_of(const SimulateOption& option, const Study& study) {
  return {
      .episodes = option.episodes, .steps = option.steps ? *option.steps : learned_steps(study), .seed = option.seed};
}

}  // namespace coppice
