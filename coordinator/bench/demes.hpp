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

// What a run would gain on such hosts: with an epoch of c seconds on a core, k processor seconds of the coordinator for
// it, and D demes, at most min(D, hosts x cores, c / k) times the serial run.
struct DemePlan {
  double epoch_seconds = 0.0;        // c
  double coordinator_seconds = 0.0;  // k
  double bytes_per_second = 0.0;     // both ways, at the speed predicted
  double speed_up = 1.0;
  std::string limit;  // what keeps it from more
};
// By the last of its rows on workers. REQUIRES: there is one.
DemePlan plan_of(const DemeScaling& scaling, const Hosts& hosts);

}  // namespace coppice
