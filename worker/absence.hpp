// A line now and then while a worker has no coordinator, with the likely cause: after 10 s, then after ever longer
// times, up to an hour. Belongs to one thread.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <string>

#include "worker/serve.hpp"

namespace coppice {

class Absence {
 public:
  using Clock = std::chrono::steady_clock;

  explicit Absence(const ServeOptions& options) : options_(options) { somebody(); }

  // Nobody is there; `met` counts other programs that DDS has met. Logs a line if it is time to.
  void nobody(const std::function<std::size_t()>& met);
  void somebody();

  // What became of a datagram to the coordinator's port.
  enum class Knock : std::uint8_t { silence, nothing_listens, cannot_be_sent };
  // In words: why no coordinator may be there.
  static std::string likely_cause(Knock knock, std::size_t met, const ServeOptions& options, const std::string& error);

 private:
  const ServeOptions& options_;
  Clock::time_point since_;
  std::chrono::seconds next_;  // after `since_`
};

}  // namespace coppice
