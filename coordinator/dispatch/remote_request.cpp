#include "coordinator/dispatch/remote_request.hpp"

#include <algorithm>
#include <numeric>

#include "common/check.hpp"
#include "common/wire/codec.hpp"
#include "common/wire/topics.hpp"

namespace coppice {
namespace {

constexpr std::uint32_t kPortion = 256;  // trees that are looked at before messages are taken in again: 0.2 ms
// A task's trees; far below the contract's bound, a UDP datagram's size.
constexpr std::size_t kTaskBytes = std::size_t{64} * 1024;

std::uint32_t most_trees(std::span<const Tree> trees, const Job& job) {
  std::size_t largest = 1;
  for (const Tree& tree : trees) {
    largest = std::max(largest, wire::most_encoded_bytes(tree.size()));
  }
  const std::size_t answers =
      (wire::kMaxTaskPayload - sizeof(std::uint32_t)) / wire::encoded_tally_size(job.objectives.size());
  return static_cast<std::uint32_t>(
      std::max<std::size_t>(std::min({kTaskBytes / largest, answers, wire::kMaxTreesPerTask}), 1));
}

}  // namespace

RemoteRequest::RemoteRequest(std::span<const Tree> trees, const Job& job, bool seek_repeats)
    : trees_(trees),
      job_(job),
      seek_repeats_(seek_repeats),
      steps_(tally_steps(job)),
      most_per_task_(most_trees(trees, job)) {
  COPPICE_CHECK(trees.size() < (std::size_t{1} << 31U));
}

std::uint32_t RemoteRequest::see_portion(Meanings& meanings) {
  const auto before = to_send();
  if (!seek_repeats_) {
    seen_ = static_cast<std::uint32_t>(trees_.size());
    sent_.resize(seen_);
    std::iota(sent_.begin(), sent_.end(), 0);
    sent_as_ = sent_;
  } else {
    for (const std::uint32_t end = seen_ + std::min(kPortion, unseen()); seen_ < end; ++seen_) {
      const auto place = met_.emplace(meanings.of(trees_[seen_]), to_send()).first->second;
      if (place == to_send()) {
        sent_.push_back(seen_);
      }
      sent_as_.push_back(place);
    }
  }
  tallies_.resize(sent_.size());
  settled_by_.resize(sent_.size());
  return to_send() - before;
}

std::vector<std::uint8_t> RemoteRequest::task(std::uint32_t first, std::uint32_t count) const {
  return wire::encode_task(job_, trees_, std::span(sent_).subspan(first, count));
}

bool RemoteRequest::fits(std::span<const Tally> tallies, std::uint32_t first) const {
  for (std::size_t i = 0; i < tallies.size(); ++i) {
    const bool steps_fit = tallies[i].steps == steps_ || (job_.method != Method::rollouts && tallies[i].steps == 0);
    if (tallies[i].nodes != trees_[sent_[first + i]].size() || !steps_fit) {
      return false;
    }
  }
  return true;
}

std::vector<std::uint32_t> RemoteRequest::settled_by(WorkerId worker) const {
  std::vector<std::uint32_t> places;
  for (std::uint32_t place = 0; place < settled_by_.size(); ++place) {
    if (settled_by_[place] == worker) {
      places.push_back(place);
    }
  }
  return places;
}

std::uint32_t RemoteRequest::give_up(std::uint32_t place) {
  tallies_[place] = Tally{};
  tallies_[place].scores.assign(job_.objectives.size(), 0);
  return sent_[place];
}

std::vector<Tally> RemoteRequest::take_tallies() {
  COPPICE_CHECK(unseen() == 0);
  std::vector<Tally> tallies;
  if (sent_.size() == trees_.size()) {
    tallies = std::move(tallies_);
  } else {
    tallies.reserve(trees_.size());
    for (const std::uint32_t place : sent_as_) {
      tallies.push_back(tallies_[place]);
    }
  }
  for (std::size_t slot = 0; slot < trees_.size(); ++slot) {
    tallies[slot].nodes = static_cast<std::uint32_t>(trees_[slot].size());
  }
  return tallies;
}

}  // namespace coppice
