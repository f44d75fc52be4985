#include "coordinator/dispatch/cross_check.hpp"

#include <algorithm>
#include <set>

#include "coordinator/dispatch/serial_evaluator.hpp"

namespace coppice {

std::vector<std::uint32_t> CrossCheck::sample(WorkerId worker, std::uint32_t count) {
  last_sample_.clear();
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
  last_sample_.assign(chosen.begin(), chosen.end());
  return last_sample_;
}

bool CrossCheck::was_sampled(std::uint32_t individual) const {
  return std::binary_search(last_sample_.begin(), last_sample_.end(), individual);
}

void CrossCheck::begin_again() {
  for (auto& [worker, record] : records_) {
    record.unchecked = 0;
  }
}

Result<std::vector<Tally>> CrossCheck::evaluate(std::span<const Tree> trees, const Job& job) {
  if (reference_ == nullptr) {
    auto reference = SerialEvaluator::make(chain_, stop_);
    if (!reference) {
      return tl::unexpected(reference.error());
    }
    reference_ = std::move(*reference);
  }
  return reference_->evaluate(trees, job);
}

}  // namespace coppice
