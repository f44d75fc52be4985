#include "coordinator/bench/measurement.hpp"

#include <algorithm>
#include <cmath>
#include <ctime>

#include "common/check.hpp"

namespace coppice {
namespace {

double processor_time() {
  timespec time{};
  COPPICE_CHECK(clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time) == 0);
  return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_nsec) * 1e-9;
}

// Linear between the two values that are nearest. REQUIRES: sorted, not empty.
double quantile(const std::vector<double>& values, double share) {
  const double at = share * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(std::floor(at));
  const std::size_t above = std::min(below + 1, values.size() - 1);
  return values[below] + (at - static_cast<double>(below)) * (values[above] - values[below]);
}

}  // namespace

Spread spread_of(std::vector<double> values) {
  COPPICE_CHECK(!values.empty());
  std::sort(values.begin(), values.end());
  return {quantile(values, 0.5), quantile(values, 0.25), quantile(values, 0.75)};
}

Stopwatch::Stopwatch() : begin_(std::chrono::steady_clock::now()), processor_begin_(processor_time()) {}

double Stopwatch::seconds() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
}

double Stopwatch::processor_seconds() const { return processor_time() - processor_begin_; }

}  // namespace coppice
