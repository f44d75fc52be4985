// How fast a chain reaches a worker that does not have it: by the real programs, from the worker's start until it holds
// the chain, less the same for a chain of a few bytes; beside the same blocks over the bare topics.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "common/chain/chain.hpp"
#include "common/error.hpp"
#include "common/stop.hpp"
#include "coordinator/bench/measurement.hpp"

namespace coppice {

struct TransferSettings {
  std::uint32_t repetitions = 7;
  std::filesystem::path worker_program;
};

struct Transfer {
  std::uint64_t bytes = 0;  // canonical, of the chain
  std::size_t blocks = 0;   // they travel in
  Spread start_seconds;     // a worker starts, meets the coordinator, and holds a tiny chain
  Spread seconds;           // more than that for this chain: sent, hashed, decoded, ready to be evaluated on
  Spread bare_seconds;      // the same blocks, as many at once, answered with a few bytes
  Spread share;             // bare / seconds, repetition by repetition: of the bare rate
};

// Errors: as FleetEvaluator and Echo.
Result<Transfer> measure_transfer(const std::shared_ptr<const Chain>& chain, const TransferSettings& settings,
                                  const StopFlag& stop);

}  // namespace coppice
