// Evolution in several demes: gives out epochs as soon as they can begin, and takes them in whatever order they end.
// What is told of a run (statistics, checkpoints, the answer) speaks of whole epochs only, so it does not depend on
// that order.
#pragma once

#include <optional>

#include "coordinator/evolution/evolve.hpp"

namespace coppice {

// As evolve(), which calls it. Without an evolver demes are bred here, one after another, and evaluated slot by slot.
// REQUIRES: check_config(); without several demes, no checkpoint to start from.
Result<Evolved> evolve_demes(const Chain& chain, const EvolveConfig& config, Evaluator& evaluator,
                             std::optional<Checkpoint> start, const EvolveHooks& hooks);

// A generation's row of the statistics, from those of its demes; `seconds` is left out. REQUIRES: one record of each
// deme, all of one generation.
GenerationRecord united(std::span<const GenerationRecord> of_demes, const GaConfig& ga);

}  // namespace coppice
