#include "coordinator/dispatch/cross_check.hpp"

#include <algorithm>
#include <set>

namespace coppice {

std::vector<std::uint32_t> CrossCheck::sample(WorkerId worker, std::uint32_t count) {
  if (share_ <= 0.0 || count == 0) {
    return {};
  }
  Record& record = records_[worker];
  record.due += share_ * count;
  if (record.answers++ < kFirstAnswers) {
    record.due = std::max(record.due, 1.0);
  }
  std::set<std::uint32_t> chosen;
  std::uniform_int_distribution<std::uint32_t> any(0, count - 1);
  while (record.due >= 1.0 && chosen.size() < count) {
    if (chosen.insert(any(random_)).second) {
      record.due -= 1.0;
    }
  }
  return {chosen.begin(), chosen.end()};
}

void CrossCheck::forget_unchecked(WorkerId worker, std::uint64_t units) {
  if (const auto found = records_.find(worker); found != records_.end()) {
    found->second.unchecked -= std::min(found->second.unchecked, units);
  }
}

void CrossCheck::begin_again() {
  for (auto& [worker, record] : records_) {
    record.unchecked = 0;
  }
}

}  // namespace coppice
