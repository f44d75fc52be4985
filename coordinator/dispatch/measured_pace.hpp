// What an individual takes at one worker, learned from its answers: the mean over about the last kMemory individuals.
// It forgets when the job's size changes, and doubts a measurement that no later one confirms: a worker that was held
// up once would otherwise be taken for slow for ever, because it is given nothing that could show the contrary.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>

namespace coppice {

class MeasuredPace {
 public:
  static constexpr double kMemory = 50.0;  // individuals
  static constexpr double kDoubt = 0.7;    // what remains of the cost after a generation without an answer

  // An answer: so many individuals of `steps` walked steps took so long. REQUIRES: individuals >= 1.
  void add(std::chrono::nanoseconds elapsed, std::uint32_t individuals, std::uint64_t steps) {
    if (steps != steps_) {
      *this = MeasuredPace{};
      steps_ = steps;
    }
    const double count = individuals;
    const double each = static_cast<double>(elapsed.count()) / count;
    weight_ = std::min(weight_, kMemory);
    each_ += (each - each_) * count / (weight_ + count);
    weight_ += count;
    confirmed_ = true;
  }
  void begin_generation() {
    each_ *= confirmed_ ? 1.0 : kDoubt;
    confirmed_ = false;
  }
  // Of an individual of `steps` walked steps; 0: not known.
  std::chrono::nanoseconds each(std::uint64_t steps) const {
    return std::chrono::nanoseconds(steps == steps_ ? static_cast<std::int64_t>(each_) : 0);
  }

 private:
  std::uint64_t steps_ = 0;
  double each_ = 0.0;    // nanoseconds
  double weight_ = 0.0;  // individuals
  bool confirmed_ = true;
};

}  // namespace coppice
