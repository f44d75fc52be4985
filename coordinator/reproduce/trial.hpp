// One evolution of an experiment of the thesis, kept in a study and scored; and several of them, over seeds. The answer
// of an experiment is the trial whose tree did best on its own final sample: what evolution may look at. The simulator,
// which judges, chooses nothing.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/error.hpp"
#include "common/evolution/config.hpp"
#include "common/stop.hpp"
#include "common/tree/tree.hpp"
#include "coordinator/dispatch/evaluator.hpp"
#include "coordinator/learning/world.hpp"
#include "coordinator/report/score.hpp"
#include "coordinator/study/study.hpp"

namespace coppice {

// An experiment as a user would type it: what is changed of thesis Table III, in the words of --set.
struct Experiment {
  std::string name;
  std::vector<std::string> settings;
};

struct Trial {
  std::uint64_t seed = 0;
  Tree tree{ActionId{0}};
  Tree pruned{ActionId{0}};
  double fitness = 0.0;
  double agreement = 0.0;  // along the walks that it was evolved on: the final sample's
  std::uint32_t best_generation = 0;
  double accumulated_q = 0.0;  // expected sum of Q(s, a) along the chain, over the roll-outs' steps
  ControllerScore score;       // in the simulator, and over all states
};

// What the trials of one study share.
struct TrialBench {
  const World& world;
  Study& study;
  Evaluator& evaluator;
  std::string evaluator_name;
  SimulateSettings simulate;
  const StopFlag& stop;
  // After each generation: shows progress.
  std::function<void(const std::string& label, std::uint32_t generation)> progress;
};

// Errors: a setting that is wrong; as evolve(), the study and the simulator (interrupted).
Result<Trial> run_trial(const Experiment& experiment, std::uint64_t seed, const TrialBench& bench);

// Seeds 1 to `seeds`. `done` after each.
Result<std::vector<Trial>> run_trials(const Experiment& experiment, std::uint32_t seeds, const TrialBench& bench,
                                      const std::function<void()>& done);

// The highest fitness; ties: fewer nodes, then the lower seed. REQUIRES: trials is not empty.
const Trial& best_of(const std::vector<Trial>& trials);

// Expected sum of Q(s, a) over `steps` steps along the chain (common/chain/exact.hpp), of whatever takes these actions.
// [states], the number of actions standing for none.
double accumulated_q(const Chain& chain, const std::vector<std::uint8_t>& actions, std::uint32_t steps);

// "coppice evolve STUDY --serial --set ... --seed N".
std::string command_of(const Experiment& experiment, std::uint64_t seed, const std::string& study);

}  // namespace coppice
