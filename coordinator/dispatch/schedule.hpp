// Who gets what next: the rules of batch_size.hpp applied to all workers and the in-flight table. Pure: time and paces
// are passed in, so that a whole request can be played through in a test.
#pragma once

#include <span>
#include <vector>

#include "coordinator/dispatch/batch_size.hpp"
#include "coordinator/dispatch/in_flight.hpp"

namespace coppice {

// A worker that can be given something.
struct ReadyWorker {
  WorkerId id{};
  WorkerPace pace;
};

struct Assignment {
  WorkerId worker{};
  Batch batch;
  bool copy = false;
};

// Enters into the in-flight table what should go out now, and returns it in the order of sending: to the first that
// will be free first; copies when nothing waits and nothing comes. `coming`: units that will wait, but are not in the
// in-flight table yet. REQUIRES: every worker is in the in-flight table.
std::vector<Assignment> next_assignments(InFlight& flight, std::span<const ReadyWorker> workers, std::uint32_t coming,
                                         InFlight::Time now);

}  // namespace coppice
