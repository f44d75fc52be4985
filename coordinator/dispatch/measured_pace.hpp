// What a unit takes at one worker, learned from its answers: for each class of work, the mean over about the last
// kMemory units. It doubts measurements that no later one confirms: a worker that was held up once would otherwise be
// taken for slow for ever, because it is given nothing that could show the contrary.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <vector>

#include "coordinator/dispatch/work.hpp"

namespace coppice {

class MeasuredPace {
 public:
  static constexpr double kMemory = 50.0;  // units
  static constexpr double kDoubt = 0.7;    // what remains of the cost after a request without an answer
  static constexpr int kDoubtEvery = 4;    // units

  static constexpr std::size_t kClasses = 16;  // the classes of work that were met last

  // An answer: so many units took so long. REQUIRES: units >= 1.
  void add(std::chrono::nanoseconds elapsed, std::uint32_t units, const WorkClass& work) {
    auto met = find(work);
    if (met == met_.end()) {
      met_.resize(std::min(met_.size(), kClasses - 1));
      met = met_.insert(met_.begin(), Met{.work = work});
    }
    const double count = units;
    const double each = static_cast<double>(elapsed.count()) / count;
    met->weight = std::min(met->weight, kMemory);
    met->each += (each - met->each) * count / (met->weight + count);
    met->weight += count;
    confirmed_ = true;
  }
  // More is asked for, and the worker has nothing to do: what was measured before is doubted unless an answer came
  // since the last time, and no more often than kDoubtEvery units are thought to take, however many requests are
  // opened. The next answer then counts alone.
  void doubt(std::chrono::steady_clock::time_point now) {
    if (now - doubted_ < kDoubtEvery * slowest()) {
      return;
    }
    doubted_ = now;
    for (Met& met : met_) {
      met.each *= confirmed_ ? 1.0 : kDoubt;
      met.weight *= confirmed_ ? 1.0 : 0.0;
    }
    confirmed_ = false;
  }
  // Of a unit; 0: not known.
  std::chrono::nanoseconds each(const WorkClass& work) const {
    const auto met = std::find_if(met_.begin(), met_.end(), [&](const Met& at) { return at.work == work; });
    return std::chrono::nanoseconds(met == met_.end() ? 0 : static_cast<std::int64_t>(met->each));
  }

 private:
  struct Met {
    WorkClass work;
    double each = 0.0;    // nanoseconds
    double weight = 0.0;  // units
  };
  std::chrono::nanoseconds slowest() const {
    double each = 0.0;
    for (const Met& met : met_) {
      each = std::max(each, met.each);
    }
    return std::chrono::nanoseconds(static_cast<std::int64_t>(each));
  }
  std::vector<Met>::iterator find(const WorkClass& work) {
    return std::find_if(met_.begin(), met_.end(), [&](const Met& at) { return at.work == work; });
  }

  std::vector<Met> met_;
  bool confirmed_ = true;
  std::chrono::steady_clock::time_point doubted_{};
};

}  // namespace coppice
