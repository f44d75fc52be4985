// One evolution in a study, saved generation by generation, whose workers may be found out to have lied before. What a
// late liar said has then bred generations already, and nobody knows which of them it spoiled: the run goes back to
// where this process began it, without that worker. Since an evolution is a pure function of (chain, config), that
// costs time only.
#pragma once

#include <cstdint>
#include <optional>

#include "coordinator/commands/evolve_options.hpp"

namespace coppice {

// A worker that comes back under another name lies as often as it likes: then the run fails.
inline constexpr std::uint32_t kMostFreshStarts = 5;

struct HonestEvolution {
  Result<Evolved> evolved;
  std::uint32_t fresh_starts = 0;
};

// `start` is where this process takes the run up: none for the first generation. `taken_back` is set by the evaluator
// (RemoteOptions). Errors: evolve(), the study; when too many workers lied, it holds the run as it was at `start`.
HonestEvolution evolve_honestly(Study& study, RunId run, const EvolveConfig& config,
                                const std::optional<Checkpoint>& start, Evaluator& evaluator, bool& taken_back,
                                const EvolveHooks& hooks);

}  // namespace coppice
