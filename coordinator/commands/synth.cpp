#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <memory>
#include <nlohmann/json.hpp>

#include "coordinator/commands/commands.hpp"
#include "coordinator/commands/shared_flags.hpp"
#include "coordinator/commands/whole_number.hpp"
#include "coordinator/console/json_line.hpp"
#include "coordinator/learning/synthetic_chain.hpp"
#include "coordinator/learning/world.hpp"
#include "coordinator/study/study.hpp"

namespace coppice {
namespace {

struct SynthFlags {
  std::string study;
  SyntheticShape shape;
  bool json = false;
};

Result<void> synth_command(const SynthFlags& options) {
  if (const Result<void> checked = Study::check_new(options.study); !checked) {
    return checked;
  }
  const Result<Chain> chain = synthetic_chain(options.shape);
  if (!chain) {
    return tl::unexpected(chain.error());
  }
  const SyntheticShape& shape = options.shape;
  const nlohmann::ordered_json settings = {{"states", shape.states},
                                           {"actions", shape.actions},
                                           {"branching", shape.branching},
                                           {"features", shape.features},
                                           {"seed", shape.seed}};
  const Result<Study> study = Study::create(options.study, *chain, {kNoWorld, ""}, {json_line(settings), "{}"});
  if (!study) {
    return tl::unexpected(study.error());
  }
  if (options.json) {
    fmt::print("{}\n", json_line(nlohmann::ordered_json{{"study", options.study},
                                                        {"settings", settings},
                                                        {"transitions", chain->transitions()},
                                                        {"chain", study->chain_hash().hex()}}));
  } else {
    fmt::print("{}: {} states, {} transitions, chain {}\n", options.study, chain->states(), chain->transitions(),
               study->chain_hash().hex());
  }
  return {};
}

}  // namespace

void add_synth(CLI::App& app, Invocation& invocation) {
  const auto options = std::make_shared<SynthFlags>();
  CLI::App* command = app.add_subcommand("synth", "Start a study with a made-up chain of any size, to try Coppice on");
  command->add_option("-o,--output", options->study, "The study file to make; must not exist")
      ->type_name("STUDY")
      ->required();
  SyntheticShape& shape = options->shape;
  constexpr std::uint64_t kMost = UINT32_MAX;
  command->add_option("--states", shape.states, "States")->check(whole_number(1, kMost))->capture_default_str();
  command->add_option("--actions", shape.actions, "Actions")->check(whole_number(1, kMost))->capture_default_str();
  command->add_option("--branching", shape.branching, "Successors of each state and action")
      ->check(whole_number(1, kMost))
      ->capture_default_str();
  command->add_option("--features", shape.features, "Features")->check(whole_number(1, kMost))->capture_default_str();
  add_seed_option(*command, shape.seed, "Same seed, same chain");
  add_json_flag(*command, options->json);
  command->footer(
      "There is no world behind such a chain: 'coppice score' has nothing to simulate.\n"
      "Example:\n"
      "  coppice synth -o large.coppice --states 1000000 --actions 3 --branching 10 --features 12");
  command->callback([&invocation, options] { invocation.chosen = [options] { return synth_command(*options); }; });
}

}  // namespace coppice
