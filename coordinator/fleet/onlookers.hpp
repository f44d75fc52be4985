// What those who look on (coppice workers) are shown of a coordinator's workers: served ones, and for a while those
// that are not. It remembers what each said last; the dispatcher knows what it does. Belongs to the thread of its
// Fleet.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "common/wire/topics.hpp"
#include "coordinator/dispatch/dispatcher.hpp"
#include "coordinator/fleet/endpoints.hpp"
#include "coordinator/fleet/link.hpp"
#include "coordinator/fleet/listed_worker.hpp"

namespace coppice {

class Onlookers {
 public:
  using Time = std::chrono::steady_clock::time_point;

  // A Hello of that worker's own.
  void hear(const wire::Hello& hello, Time now);
  // Besides those on other programs' side of the wire.
  void watch(WatchWorkers watch) { watch_ = std::move(watch); }
  // Writes a Fleet, if it is time to, and somebody looks.
  void show(Endpoints& dds, const RunIdentity& run, const Dispatcher& dispatcher, Time now);

 private:
  struct Seen {
    wire::WorkerStatus status{};  // as it said last
    Time heard{};
    Time counting_since{};  // what follows
    std::uint64_t counted = 0;
    std::uint64_t each_second = 0;
  };

  std::vector<wire::WorkerStatus> workers(const Dispatcher& dispatcher, Time now) const;

  std::map<WorkerId, Seen> seen_;
  WatchWorkers watch_;
  Time next_show_{};
};

}  // namespace coppice
