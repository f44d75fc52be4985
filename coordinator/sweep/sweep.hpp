// Many runs of evolution at once on one set of workers. A run travels as a whole, or in epochs where it has several
// demes, so that nothing is sent for each generation; its last comparison is spread over all workers. Each run has a
// thread and an evaluator of its own, so its result is the one that it has alone, whatever runs beside it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/stop.hpp"
#include "coordinator/dispatch/evaluator.hpp"
#include "coordinator/evolution/evolve.hpp"
#include "coordinator/learning/world.hpp"
#include "coordinator/sweep/plan.hpp"

namespace coppice {

// What a run came to. Everything but seconds is a pure function of (chain, configuration, world, episodes).
struct SweepResult {
  double fitness = 0.0;    // of the answer, on the final sample
  double agreement = 0.0;  // likewise
  double coverage = 0.0;   // share of all states in which it does what the policy does
  double distinct = 0.0;   // different trees, as a share of the population, mean over the generations
  double meanings = 0.0;   // the same for different action tables: trees that differ in what they do. Of several demes:
                           // the sum of each one's
  std::uint64_t nodes = 0;  // after pruning on the chain
  Tree tree{ActionId{0}};   // likewise
  struct Simulated {
    double agreement = 0.0;   // share of the steps
    double reward = 0.0;      // per episode
    double collisions = 0.0;  // per episode
    bool operator==(const Simulated&) const = default;
  };
  std::optional<Simulated> simulated;  // unless there is no world
  double seconds = 0.0;                // from start to end, others running beside it
  bool operator==(const SweepResult&) const = default;
};

struct SweepSettings {
  std::size_t at_once = 1;                                    // runs
  std::function<std::unique_ptr<Evaluator>()> new_evaluator;  // one for each thread, made on the calling thread
  std::uint64_t episodes = 500;                               // in the simulator, at least 1
  std::uint32_t steps = 150;                                  // of an episode
};

// Called one at a time, from any thread.
struct SweepHooks {
  // A run of the list has ended. An error ends the sweep. May be empty.
  std::function<Result<void>(std::size_t run, const SweepResult&)> run_done;
  // A run of the list has finished a generation. May be empty.
  std::function<void(std::size_t run, const GenerationRecord&)> generation_done;
};

// Runs all of `runs`, starting them in their order; answers are simulated if there is a world. Errors: the first of any
// run or hook; `interrupted` when the stop flag was raised. What had ended before was reported. REQUIRES: at_once >= 1,
// every configuration was checked.
Result<void> sweep(const Chain& chain, const World* world, const std::vector<SweepRun>& runs,
                   const SweepSettings& settings, const SweepHooks& hooks, const StopFlag& stop);

}  // namespace coppice
