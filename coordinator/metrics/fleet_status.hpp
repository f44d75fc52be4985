// How a fleet is at one moment, as it tells whoever watches it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "coordinator/dispatch/dispatcher.hpp"
#include "coordinator/dispatch/evaluator.hpp"

namespace coppice {

struct FleetStatus {
  DispatchStatistics statistics;
  std::uint64_t epochs = 0;                     // of demes, that ended
  std::map<std::string, SourceRecord> sources;  // Dispatcher::sources()
  std::size_t joining = 0;                      // workers that do not hold the chain yet, or cannot be reached yet
  std::size_t idle = 0;                         // that are ready and have nothing to do
  std::size_t evaluating = 0;
  std::size_t lanes = 0;  // of those that are ready
  std::size_t lanes_busy = 0;
  std::uint64_t waiting = 0;                                       // units that are not out at any worker
  std::uint64_t in_flight = 0;                                     // units that are, copies included
  std::size_t requests = 0;                                        // open
  std::vector<std::pair<std::string, std::int64_t>> certificates;  // file, when it ends (Unix time)
};

}  // namespace coppice
