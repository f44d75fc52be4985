#include "coordinator/commands/honest_evolution.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

namespace coppice {

HonestEvolution evolve_honestly(Study& study, RunId run, const EvolveConfig& config,
                                const std::optional<Checkpoint>& start, Evaluator& evaluator, bool& taken_back,
                                const EvolveHooks& hooks) {
  const std::uint32_t first = start ? start->generation + 2 : 1;  // counted from 1, as progress does
  for (std::uint32_t fresh_starts = 0;; ++fresh_starts) {
    taken_back = false;
    Result<Evolved> evolved = evolve(study.chain(), config, evaluator, start, hooks);
    if (evolved || !taken_back) {
      return {std::move(evolved), fresh_starts};
    }
    if (const Result<void> rewound = study.rewind_run(run, start); !rewound) {
      return {tl::unexpected(rewound.error()), fresh_starts};
    }
    if (fresh_starts == kMostFreshStarts) {
      return {failed(fmt::format("{}; begun again {} times: keep such workers out (--security), or have everything "
                                 "checked (--cross-check 1)",
                                 evolved.error().message, fresh_starts)),
              fresh_starts};
    }
    spdlog::warn("what that worker said is in what was bred since: generation {} and all after it are done again",
                 first);
  }
}

}  // namespace coppice
