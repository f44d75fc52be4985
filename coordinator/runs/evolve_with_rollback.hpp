// One evolution in a study, saved generation by generation, that survives workers which are found to lie. What such a
// worker said before it was found out has bred generations already, and nobody knows which of them it spoiled: the run
// goes back to where this process took it up, and is bred again without that worker. Since an evolution is a pure
// function of (chain, configuration), that costs time only.
#pragma once

#include <cstdint>
#include <optional>

#include "coordinator/dispatch/evaluator.hpp"
#include "coordinator/evolution/evolve.hpp"
#include "coordinator/study/study.hpp"

namespace coppice {

// A worker that comes back under another name lies as often as it likes: then the run fails.
inline constexpr std::uint32_t kMostRollbacks = 5;

struct EvolutionWithRollback {
  Result<Evolved> evolved;
  std::uint32_t rollbacks = 0;
};

// `start` is where this process takes the run up: none for the first generation. Errors: evolve(), the study; when too
// many workers lied (ErrorKind::revoked), the study holds the run as it was at `start`.
EvolutionWithRollback evolve_with_rollback(Study& study, RunId run, const EvolveConfig& config,
                                           const std::optional<Checkpoint>& start, Evaluator& evaluator,
                                           const EvolveHooks& hooks);

}  // namespace coppice
