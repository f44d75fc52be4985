// What workers gain and what they cost: every workload on the serial path, on several serial paths at once (what these
// cores give where nothing is dispatched), on N workers, and its batches on the bare transport, in turn and repeatedly,
// in one process on one machine. Every remote tally is compared with the serial one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/error.hpp"
#include "common/stop.hpp"
#include "coordinator/bench/measurement.hpp"
#include "coordinator/bench/workload.hpp"

namespace coppice {

// Worker processes of so many evaluating threads each.
struct Team {
  std::size_t workers = 1;
  std::uint32_t threads = 1;

  std::size_t lanes() const { return workers * threads; }
  std::string name() const;  // "2 workers", "1 worker x 2"
  bool operator==(const Team&) const = default;
};

struct ScalingSettings {
  std::vector<Team> teams = {{1}, {2}, {4}};
  std::uint32_t repetitions = 7;
  std::filesystem::path worker_program;
  std::filesystem::path security = {};  // holds identities under DDS Security, coordinator/ and worker/; empty: none
  unsigned cores = 1;                   // threads beyond them are not expected to gain
};

// Of one workload; seconds are those of one generation.
struct ScalingRow {
  Team team;
  Spread seconds;
  Spread speed_up;      // serial / this, repetition by repetition
  Spread overhead;      // seconds beyond serial / min(threads of all workers, cores)
  Spread bare_seconds;  // the same batches answered at once, over bare DDS
  double efficiency = 0.0;
  double batches = 0.0;  // a generation
  double bytes = 0.0;    // payload both ways, an individual
  double busy = 0.0;     // of a core: the coordinator's process
};

struct WorkloadScaling {
  std::string name;
  std::size_t individuals = 0;
  std::uint32_t rollouts = 0;
  std::uint32_t steps = 0;
  Spread serial_seconds;
  std::size_t abreast = 0;  // serial paths at once, each with generations of its own: as many as cores are used
  Spread abreast_seconds;   // over `abreast`
  Spread abreast_speed_up;  // serial / this, repetition by repetition
  std::vector<ScalingRow> rows;
};

// `done` is called after each workload. Errors: as FleetEvaluator; failed: a remote tally differs from the serial one.
Result<std::vector<WorkloadScaling>> measure_scaling(const std::shared_ptr<const Chain>& chain,
                                                     const std::vector<Workload>& workloads,
                                                     const ScalingSettings& settings, const StopFlag& stop,
                                                     const std::function<void(const WorkloadScaling&)>& done);

// From which serial time of a generation on a team gains, by the overhead that was measured with the smallest
// workload that has work in it; 0: never.
double worthwhile_seconds(const std::vector<WorkloadScaling>& scaling, const Team& team, unsigned cores);

}  // namespace coppice
