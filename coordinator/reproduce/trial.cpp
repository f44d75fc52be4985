#include "coordinator/reproduce/trial.hpp"

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "common/chain/exact.hpp"
#include "common/check.hpp"
#include "common/tree/action_table.hpp"
#include "common/tree/simplify.hpp"
#include "common/tree/state_columns.hpp"
#include "coordinator/console/json_line.hpp"
#include "coordinator/evolution/config_text.hpp"
#include "coordinator/evolution/evolve.hpp"
#include "coordinator/learning/simulate.hpp"

namespace coppice {
namespace {

Result<EvolveConfig> config_of(const Experiment& experiment, std::uint64_t seed, const Vocabulary& vocabulary) {
  EvolveConfig config;
  for (const std::string& setting : experiment.settings) {
    if (const Result<void> applied = apply_setting(setting, config); !applied) {
      return tl::unexpected(applied.error());
    }
  }
  config.seed = seed;
  if (const Result<void> checked = check_config(config, vocabulary); !checked) {
    return tl::unexpected(checked.error());
  }
  return config;
}

// Evolves as a run of the study.
Result<Evolved> evolve_and_keep(const EvolveConfig& config, const std::string& label, const TrialBench& bench) {
  const Result<RunId> run = bench.study.begin_run({config, bench.evaluator_name});
  if (!run) {
    return tl::unexpected(run.error());
  }
  EvolveHooks hooks;
  SavePace pace;
  hooks.due = [&pace] { return pace.due(); };
  hooks.generations_done = [&](std::span<const GenerationRecord> records,
                               const Checkpoint& checkpoint) -> Result<void> {
    const auto save = [&] { return bench.study.save_generations(*run, records, checkpoint); };
    if (const Result<void> saved = pace.save(save); !saved) {
      return saved;
    }
    bench.progress(label, checkpoint.generation + 1);
    return bench.stop.raised() ? Result<void>(interrupted()) : Result<void>();
  };
  Result<Evolved> evolved = evolve(bench.study.chain(), config, bench.evaluator, std::nullopt, hooks);
  RunOutcome outcome;
  if (!evolved || evolved->interrupted) {
    const Error error = evolved ? interrupted().value() : evolved.error();
    outcome.status = error.kind == ErrorKind::interrupted ? RunStatus::interrupted : RunStatus::failed;
    outcome.json = json_line({{"error", error.message}});
    static_cast<void>(bench.study.finish_run(*run, outcome));  // the first error is the one to tell
    return tl::unexpected(error);
  }
  const Chain& chain = bench.study.chain();
  outcome.tree = evolved->best.tree;
  outcome.pruned =
      simplify(evolved->best.tree, chain.vocabulary(), StateColumns(chain.vocabulary(), chain.parts().features)).tree;
  outcome.json = json_line({{"fitness", evolved->best.fitness},
                            {"agreement", evolved->best.agreement},
                            {"experiment", label},
                            {"generations", evolved->generations_done}});
  if (const Result<void> finished = bench.study.finish_run(*run, outcome); !finished) {
    return tl::unexpected(finished.error());
  }
  return evolved;
}

}  // namespace

double accumulated_q(const Chain& chain, const std::vector<std::uint8_t>& actions, std::uint32_t steps) {
  ExactOccupancy exact(chain);
  const Occupancy& occupancy = exact.over_steps({.actions = actions, .others = {}, .others_share = 0.0}, steps);
  double sum = 0.0;
  for (std::size_t i = 0; i < occupancy.states.size(); ++i) {
    const std::size_t state = occupancy.states[i];
    if (actions[state] < chain.actions()) {
      sum += occupancy.visits[i] * chain.parts().q[state * chain.actions() + actions[state]];
    }
  }
  return sum;
}

Result<Trial> run_trial(const Experiment& experiment, std::uint64_t seed, const TrialBench& bench) {
  const Chain& chain = bench.study.chain();
  const Vocabulary& vocabulary = chain.vocabulary();
  const Result<EvolveConfig> config = config_of(experiment, seed, vocabulary);
  if (!config) {
    return tl::unexpected(config.error());
  }
  const std::string label = fmt::format("{}, seed {}", experiment.name, seed);
  const Result<Evolved> evolved = evolve_and_keep(*config, label, bench);
  if (!evolved) {
    return tl::unexpected(evolved.error());
  }
  const StateColumns columns(vocabulary, chain.parts().features);
  Trial trial{.seed = seed,
              .tree = evolved->best.tree,
              .pruned = simplify(evolved->best.tree, vocabulary, columns).tree,
              .fitness = evolved->best.fitness,
              .agreement = evolved->best.agreement,
              .best_generation = evolved->best.generation,
              .accumulated_q = 0.0,
              .score = {}};
  const ChainActions actions = actions_of(chain, trial.tree);
  trial.accumulated_q = accumulated_q(chain, actions, config->rollout.steps);
  const auto episodes =
      simulate_tree(bench.world, chain, trial.tree, bench.simulate, [&] { return !bench.stop.raised(); });
  if (!episodes) {
    return tl::unexpected(episodes.error());
  }
  trial.score = controller_score(*episodes);
  trial.score.matching_states = matching_states(chain, actions);
  return trial;
}

Result<std::vector<Trial>> run_trials(const Experiment& experiment, std::uint32_t seeds, const TrialBench& bench,
                                      const std::function<void()>& done) {
  std::vector<Trial> trials;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    Result<Trial> trial = run_trial(experiment, seed, bench);
    if (!trial) {
      return tl::unexpected(std::move(trial).error());
    }
    trials.push_back(std::move(*trial));
    done();
  }
  return trials;
}

const Trial& best_of(const std::vector<Trial>& trials) {
  COPPICE_CHECK(!trials.empty());
  return *std::max_element(trials.begin(), trials.end(), [](const Trial& a, const Trial& b) {
    if (a.fitness != b.fitness) {
      return a.fitness < b.fitness;
    }
    return a.tree.size() != b.tree.size() ? a.tree.size() > b.tree.size() : a.seed > b.seed;
  });
}

std::string command_of(const Experiment& experiment, std::uint64_t seed, const std::string& study) {
  std::string command = fmt::format("coppice evolve {} --serial --seed {}", study, seed);
  for (const std::string& setting : experiment.settings) {
    command += " --set " + setting;
  }
  return command;
}

}  // namespace coppice
