// The worker's main loop. It meets the coordinator, fetches the chains that it lacks and says Hello; lanes (lane.hpp)
// do the evaluating, each in a thread of its own.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "common/error.hpp"
#include "common/evolution/epoch.hpp"
#include "common/fitness/golden_job.hpp"
#include "common/fitness/job.hpp"
#include "common/stop.hpp"
#include "common/wire/configuration.hpp"
#include "worker/figures.hpp"

namespace coppice {

struct ServeOptions {
  std::string coordinator = "127.0.0.1";
  std::uint32_t domain = 0;
  wire::Network network;
  std::uint32_t threads = 1;
  std::vector<int> cores;            // of the threads, one each; empty: wherever the system likes
  std::chrono::nanoseconds pace{0};  // see WorkerState
  std::string cache;                 // folder for chains that outlive this process; empty: none
  std::uint32_t protocol = 0;        // what this program speaks; coordinators that speak another are refused
  std::string version;
  std::uint64_t golden = golden_checksum();  // coordinators that compute otherwise are refused
  std::shared_ptr<WorkerFigures> figures = std::make_shared<WorkerFigures>();  // kept while it serves
  // Tests only: called with the tallies of every batch before they are sent.
  std::function<void(std::span<Tally>)> before_answer;
  std::function<void(EpochResult&)> before_epoch_answer;  // likewise, of every epoch
};

// Serves one coordinator after another until `stop` is raised, then gives back what it holds and returns. While there
// is none, or none can be reached, it waits, and keeps the chains that it holds. Errors: a coordinator of another
// protocol version, or of a build that computes otherwise; a chain that comes damaged again and again; a cache that
// cannot be written (bad_input).
Result<void> serve(const ServeOptions& options, const StopFlag& stop);

}  // namespace coppice
