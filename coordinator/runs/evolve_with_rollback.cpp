#include "coordinator/runs/evolve_with_rollback.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

namespace coppice {

EvolutionWithRollback evolve_with_rollback(Study& study, RunId run, const EvolveConfig& config,
                                           const std::optional<Checkpoint>& start, Evaluator& evaluator,
                                           const EvolveHooks& hooks) {
  const std::uint32_t first = start ? start->generation + 2 : 1;  // counted from 1, as progress does
  for (std::uint32_t rollbacks = 0;; ++rollbacks) {
    Result<Evolved> evolved = evolve(study.chain(), config, evaluator, start, hooks);
    if (evolved || evolved.error().kind != ErrorKind::revoked) {
      return {std::move(evolved), rollbacks};
    }
    if (const Result<void> rewound = study.rewind_run(run, start); !rewound) {
      return {tl::unexpected(rewound.error()), rollbacks};
    }
    if (rollbacks == kMostRollbacks) {
      const std::string advice = fmt::format(
          "{}; the run was rolled back {} times: keep such workers out (--security), or have every individual "
          "checked (--cross-check 1)",
          evolved.error().message, rollbacks);
      return {tl::unexpected(Error{ErrorKind::revoked, advice}), rollbacks};
    }
    spdlog::warn("rolling back: generation {} and all after it were bred from that worker's answers and are bred again",
                 first);
  }
}

}  // namespace coppice
