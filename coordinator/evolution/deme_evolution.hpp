// Evolution in several demes: gives out epochs as soon as they can begin, and takes them in whatever order they end.
// What is told of a run (statistics, checkpoints, the answer) speaks of whole epochs only, so it does not depend on
// that order.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "common/evolution/deme.hpp"
#include "common/evolution/deme_search.hpp"
#include "coordinator/evolution/evolve.hpp"
#include "coordinator/evolution/final_choice.hpp"

namespace coppice {

// What evolve() has made ready. The references outlive the evolution.
struct EvolutionParts {
  const Chain& chain;
  const EvolveConfig& config;
  FinalChoice choice;
  std::unique_ptr<DemeSearch> search;
  Evaluator& evaluator;
  const EvolveHooks& hooks;
};

// As evolve(), which calls it. Without an evolver demes are bred here, one after another, and evaluated slot by slot.
// REQUIRES: check_config(); without several demes, no checkpoint to start from.
Result<Evolved> evolve_demes(EvolutionParts parts, std::optional<Checkpoint> start);

// Nothing is asked where there are no trees.
Result<std::vector<Tally>> evaluate_some(Evaluator& evaluator, std::span<const Tree> trees, const Job& job);

// The demes as they stood at a checkpoint, which is checked first and gives up its trees. Everything is measured anew:
// the samples are the same, so are the numbers. [demes]
Result<std::vector<Deme>> measured_again(Checkpoint& start, const EvolveConfig& config, const Breeding& breeding,
                                         const Job& job, Evaluator& evaluator);

// A generation's row of the statistics, from those of its demes; `seconds` is left out. REQUIRES: one record of each
// deme, all of one generation.
GenerationRecord united(std::span<const GenerationRecord> of_demes, const GaConfig& ga);

}  // namespace coppice
