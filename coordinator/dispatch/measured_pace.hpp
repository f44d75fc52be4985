// What an individual takes at one worker, learned from its answers: for jobs of each size, the mean over about the last
// kMemory individuals. It doubts measurements that no later one confirms: a worker that was held up once would
// otherwise be taken for slow for ever, because it is given nothing that could show the contrary.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <vector>

namespace coppice {

class MeasuredPace {
 public:
  static constexpr double kMemory = 50.0;  // individuals
  static constexpr double kDoubt = 0.7;    // what remains of the cost after a generation without an answer

  static constexpr std::size_t kSizes = 16;  // the job sizes that were met last

  // An answer: so many individuals of `steps` walked steps took so long. REQUIRES: individuals >= 1.
  void add(std::chrono::nanoseconds elapsed, std::uint32_t individuals, std::uint64_t steps) {
    auto size = find(steps);
    if (size == sizes_.end()) {
      sizes_.resize(std::min(sizes_.size(), kSizes - 1));
      size = sizes_.insert(sizes_.begin(), Size{.steps = steps});
    }
    const double count = individuals;
    const double each = static_cast<double>(elapsed.count()) / count;
    size->weight = std::min(size->weight, kMemory);
    size->each += (each - size->each) * count / (size->weight + count);
    size->weight += count;
    confirmed_ = true;
  }
  void begin_generation() {
    for (Size& size : sizes_) {
      size.each *= confirmed_ ? 1.0 : kDoubt;
    }
    confirmed_ = false;
  }
  // Of an individual of `steps` walked steps; 0: not known.
  std::chrono::nanoseconds each(std::uint64_t steps) const {
    const auto size = std::find_if(sizes_.begin(), sizes_.end(), [&](const Size& at) { return at.steps == steps; });
    return std::chrono::nanoseconds(size == sizes_.end() ? 0 : static_cast<std::int64_t>(size->each));
  }

 private:
  struct Size {
    std::uint64_t steps = 0;
    double each = 0.0;    // nanoseconds
    double weight = 0.0;  // individuals
  };
  std::vector<Size>::iterator find(std::uint64_t steps) {
    return std::find_if(sizes_.begin(), sizes_.end(), [&](const Size& at) { return at.steps == steps; });
  }

  std::vector<Size> sizes_;
  bool confirmed_ = true;
};

}  // namespace coppice
