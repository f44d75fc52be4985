// How well dispatch fills workers of a declared pace (coppice-worker --pace), many more than there are cores: the
// time of a generation against the ideal, in which every worker is busy to the end. Every tally is compared with the
// serial one.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/error.hpp"
#include "common/stop.hpp"
#include "coordinator/bench/measurement.hpp"
#include "coordinator/fleet/local_workers.hpp"

namespace coppice {

struct PacingSettings {
  std::vector<std::size_t> workers = {1, 8, 64};
  std::chrono::nanoseconds pace{0};  // of an individual; more than 0
  std::size_t slow_workers = 0;      // of them, that many take slow_pace
  std::chrono::nanoseconds slow_pace{0};
  std::uint32_t population = 0;  // 0: kIndividualsPerWorker for each worker
  std::uint32_t repetitions = 7;
  std::filesystem::path worker_program;
};

inline constexpr std::uint32_t kIndividualsPerWorker = 50;

// The flags that give each of so many workers its pace, and the individuals a second that all of them reach together.
// REQUIRES: slow_workers <= workers.
std::vector<LocalWorkers::Flags> paced_flags(std::size_t workers, const PacingSettings& settings);
double paced_individuals_per_second(std::size_t workers, const PacingSettings& settings);

struct PacingRow {
  std::size_t workers = 0;
  std::uint32_t individuals = 0;
  double ideal_seconds = 0.0;  // of a generation
  double first_seconds = 0.0;  // of the first one: no worker's pace is known yet
  Spread seconds;
  double efficiency = 0.0;    // ideal / median
  double batches = 0.0;       // a generation
  double copies = 0.0;        // a generation
  double busy = 0.0;          // of a core: the coordinator's process
  double here_seconds = 0.0;  // from the first process' start until all workers hold the chain
  double gone_seconds = 0.0;  // until the last process has ended
};

// REQUIRES: slow_workers <= every number of workers. Errors: as FleetEvaluator; failed: a remote tally differs.
Result<std::vector<PacingRow>> measure_pacing(const std::shared_ptr<const Chain>& chain, const PacingSettings& settings,
                                              const StopFlag& stop, const std::function<void(const PacingRow&)>& done);

}  // namespace coppice
