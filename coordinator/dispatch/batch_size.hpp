// How many units of work a worker should get next: guided self-scheduling (Polychronopoulos & Kuck 1987) over workers
// of different pace. Batches shrink as the request empties so that workers finish together, between a lower bound that
// keeps the message cheaper than the work and an upper bound that keeps progress visible; and nobody is given what
// the others will have done before he is. It decides time only, never a result.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>

namespace coppice {

inline constexpr std::chrono::microseconds kShortestBatch{300};  // several times what sending it takes
inline constexpr std::chrono::milliseconds kLongestBatch{50};
inline constexpr double kGuidedShare = 0.85;  // of what a lane will have to do until the end

// One worker's measured pace.
struct WorkerPace {
  std::size_t lanes = 1;             // computing threads
  std::chrono::nanoseconds each{0};  // one unit on one lane; 0: unknown
};

// All workers that can be counted on, and what they are at.
class FleetPace {
 public:
  // A worker that has work for so long. REQUIRES: worker.lanes >= 1.
  void add(const WorkerPace& worker, std::chrono::nanoseconds remaining);
  bool known() const { return per_nanosecond_ > 0.0; }
  // In how many nanoseconds the fleet will have done what it has and `waiting` more, all lanes busy to the end.
  // REQUIRES: known().
  double end(std::uint32_t waiting) const;
  double fastest() const { return fastest_; }  // nanoseconds for one unit

 private:
  double per_nanosecond_ = 0.0;  // units, of the lanes that were measured
  double pending_ = 0.0;         // units
  std::size_t measured_ = 0;     // lanes
  std::size_t lanes_ = 0;
  double fastest_ = 0.0;
};

struct BatchRequest {
  std::uint32_t waiting = 0;  // units that nobody has
  double end = 0.0;           // FleetPace::end() of them, nanoseconds from now; 0: unknown
  double fastest = 0.0;       // FleetPace::fastest()
  WorkerPace worker;
  std::chrono::nanoseconds remaining{0};  // for so long the worker has work
};

// At most `waiting`. A worker that was never measured is tried with 1. 0: the others will be done sooner.
// REQUIRES: waiting >= 1.
std::uint32_t batch_size(const BatchRequest& request);

}  // namespace coppice
