// How many slots the next batch should hold: guided self-scheduling (Polychronopoulos & Kuck 1987), batches that shrink
// as the generation empties so that workers finish together, between a lower bound that keeps the message cheaper than
// the work and an upper bound that keeps progress visible. It decides time only, never a result.
#pragma once

#include <chrono>
#include <cstdint>

namespace coppice {

inline constexpr std::chrono::microseconds kShortestBatch{250};
inline constexpr std::chrono::milliseconds kLongestBatch{20};

struct BatchRequest {
  std::uint32_t waiting = 0;         // slots
  std::size_t lanes = 1;             // evaluating threads of all workers
  std::chrono::nanoseconds each{0};  // measured cost of one individual; 0: unknown
};

// At least 1. REQUIRES: waiting >= 1, lanes >= 1.
std::uint32_t batch_size(const BatchRequest& request);

}  // namespace coppice
