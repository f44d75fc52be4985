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

bool CrossCheck::agrees(WorkerId from, std::span<const Tally> tallies, const RemoteRequest& request,
                        std::uint32_t first) {
  std::vector<std::uint32_t> places = sample(from, static_cast<std::uint32_t>(tallies.size()));
  if (places.empty()) {
    return true;
  }
  for (std::uint32_t& place : places) {
    place += first;
  }
  const auto truth = evaluate(request, places);
  for (std::size_t i = 0; truth && i < places.size(); ++i) {
    if (tallies[places[i] - first] != (*truth)[i]) {
      return false;
    }
  }
  return true;
}

std::size_t CrossCheck::redo(RemoteRequest& request, WorkerId from) {
  const std::vector<std::uint32_t> places = request.settled_by(from);
  auto truth = evaluate(request, places);
  for (std::size_t i = 0; truth && i < places.size(); ++i) {
    request.settle(places[i], std::move((*truth)[i]), WorkerId{});
  }
  return places.size();
}

Result<std::vector<Tally>> CrossCheck::evaluate(const RemoteRequest& request, std::span<const std::uint32_t> places) {
  if (reference_ == nullptr) {
    auto reference = SerialEvaluator::make(chain_, stop_);
    if (!reference) {
      return tl::unexpected(std::move(reference).error());
    }
    reference_ = std::move(*reference);
  }
  std::vector<Tree> trees;
  trees.reserve(places.size());
  for (const std::uint32_t place : places) {
    trees.push_back(request.sent_tree(place));
  }
  return reference_->evaluate(trees, request.job());
}

}  // namespace coppice
