#include "coordinator/dispatch/batch_size.hpp"

#include <algorithm>
#include <cmath>

#include "common/check.hpp"

namespace coppice {
namespace {

double in_nanoseconds(std::chrono::nanoseconds duration) { return static_cast<double>(duration.count()); }

}  // namespace

void FleetPace::add(const WorkerPace& worker, std::chrono::nanoseconds remaining) {
  COPPICE_CHECK(worker.lanes >= 1);
  lanes_ += worker.lanes;
  const double each = in_nanoseconds(worker.each);
  if (each > 0.0) {
    const double pace = static_cast<double>(worker.lanes) / each;
    per_nanosecond_ += pace;
    pending_ += in_nanoseconds(remaining) * pace;
    measured_ += worker.lanes;
    fastest_ = fastest_ == 0.0 ? each : std::min(fastest_, each);
  }
}

double FleetPace::end(std::uint32_t waiting) const {
  COPPICE_CHECK(known());
  // Lanes that were not measured are taken for average ones.
  const double all = per_nanosecond_ * static_cast<double>(lanes_) / static_cast<double>(measured_);
  return (pending_ + static_cast<double>(waiting)) / all;
}

std::uint32_t batch_size(const BatchRequest& request) {
  COPPICE_CHECK(request.waiting >= 1);
  const double each = in_nanoseconds(request.worker.each);
  if (each <= 0.0 || request.end <= 0.0) {
    return 1;
  }
  const double left = request.end - in_nanoseconds(request.remaining);
  const double guided = std::ceil(kGuidedShare * left / each);
  const double shortest = std::ceil(in_nanoseconds(kShortestBatch) / each);
  const double longest = std::max(std::floor(in_nanoseconds(kLongestBatch) / each), 1.0);
  // What the worker will have done when the last of the others ends: a unit is not divided.
  const double in_time = std::floor((left + request.fastest) / each + 1e-9);  // rounding must not refuse equals
  const double size = std::min({std::max(guided, shortest), longest, in_time});
  return size < 1.0 ? 0 : static_cast<std::uint32_t>(std::min(size, static_cast<double>(request.waiting)));
}

}  // namespace coppice
