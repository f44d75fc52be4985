// What demes gain on threads and on workers: whole evolutions in demes, on one thread, on several at once (each its
// own: what these cores give), on the threads of this process, and on workers, in turn and repeatedly. Every one ends
// as the first does. From what was measured follows how more hosts would do.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/error.hpp"
#include "common/evolution/config.hpp"
#include "common/stop.hpp"
#include "coordinator/bench/measurement.hpp"
#include "coordinator/bench/scaling.hpp"

namespace coppice {

struct DemeWorkload {
  std::string name;
  EvolveConfig config;
};

// "thesis": Table III in eight demes of 100; "front": eight of 100 that search a front, as front.toml does.
std::vector<DemeWorkload> deme_workloads();

struct DemeRow {
  std::string name;  // "2 threads", "2 workers"
  std::size_t lanes = 1;
  Spread seconds;
  Spread speed_up;     // serial / this, repetition by repetition
  double bytes = 0.0;  // workers: payload of an individual evaluated, both ways
  double busy = 0.0;   // workers: processor seconds of this process for an epoch
};

struct DemeScaling {
  std::string name;
  std::uint32_t demes = 0;
  std::uint64_t epochs = 0;       // of all demes
  std::uint64_t individuals = 0;  // evaluated, the last comparison aside
  Spread serial_seconds;
  std::size_t abreast = 0;  // serial runs at once
  Spread abreast_speed_up;  // serial / (this / abreast)
  std::vector<DemeRow> rows;
};

// `done` is called after each workload. Errors: as FleetEvaluator; failed: a run ended otherwise than the serial one.
Result<std::vector<DemeScaling>> measure_demes(const std::shared_ptr<const Chain>& chain,
                                               const std::vector<DemeWorkload>& workloads,
                                               const ScalingSettings& settings, const StopFlag& stop,
                                               const std::function<void(const DemeScaling&)>& done);

struct Hosts {
  std::uint32_t hosts = 1;
  std::uint32_t cores = 1;  // of each
};

// What an epoch costs, in seconds.
struct EpochCosts {
  double core = 0.0;         // c, of a worker's core
  double lost = 0.0;         // o, that a worker waits for it besides: packing, the way there and back
  double coordinator = 0.0;  // k, processor time of the coordinator
};

// How many times as fast as on one core a run of D demes goes on L lanes:
//   min( min(D, L) x c / (c + o), c / k )
// Nobody waits for all others, so a number of demes that the lanes do not divide costs nothing.
double predicted_speed_up(const EpochCosts& costs, std::uint32_t demes, double lanes);

// What a run would gain on such hosts.
struct DemePlan {
  EpochCosts costs;
  double bytes_per_second = 0.0;  // both ways, at the speed predicted
  double speed_up = 1.0;
  std::string limit;  // what keeps it from more
};
// By the last of its rows on workers. REQUIRES: there is one.
DemePlan plan_of(const DemeScaling& scaling, const Hosts& hosts);

}  // namespace coppice
