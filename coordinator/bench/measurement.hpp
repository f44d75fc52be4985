// Repeated measurements and what they amount to.
#pragma once

#include <chrono>
#include <vector>

namespace coppice {

// Median and quartiles: one disturbed repetition does not move them.
struct Spread {
  double median = 0.0;
  double low = 0.0;   // a quarter of the measurements are below
  double high = 0.0;  // a quarter are above
};

// REQUIRES: !values.empty().
Spread spread_of(std::vector<double> values);

// Wall-clock time and processor time of this process (all threads), since it was made.
class Stopwatch {
 public:
  Stopwatch();
  double seconds() const;
  double processor_seconds() const;

 private:
  std::chrono::steady_clock::time_point begin_;
  double processor_begin_;
};

}  // namespace coppice
