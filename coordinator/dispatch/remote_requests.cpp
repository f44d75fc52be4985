#include "coordinator/dispatch/remote_requests.hpp"

#include <algorithm>

#include "common/check.hpp"

namespace coppice {

RequestId RemoteRequests::open(std::span<const Tree> trees, const Job& job, bool seek_repeats) {
  const RequestId id{next_++};
  open_.emplace(id, Open{RemoteRequest(trees, job, seek_repeats), {}});
  return id;
}

void RemoteRequests::see_portions(Meanings& meanings) {
  for (auto& [id, open] : open_) {
    if (open.request.unseen() == 0) {
      continue;
    }
    const std::uint32_t first = open.request.to_send();
    const std::uint32_t count = open.request.see_portion(meanings);
    if (count > 0) {
      const GenerationId portion = flight_.begin(count);
      open.portions.push_back(portion);
      portions_.emplace(portion, Portion{id, first});
    }
  }
}

bool RemoteRequests::all_seen() const {
  return std::all_of(open_.begin(), open_.end(), [](const auto& open) { return open.second.request.unseen() == 0; });
}

bool RemoteRequests::done(RequestId id) const {
  const Open& open = open_.at(id);
  return open.request.unseen() == 0 && std::all_of(open.portions.begin(), open.portions.end(),
                                                   [&](GenerationId portion) { return flight_.done(portion); });
}

RemoteRequests::Finished RemoteRequests::take(RequestId id) {
  COPPICE_CHECK(done(id));
  const auto open = open_.find(id);
  std::vector<Tally> tallies = open->second.request.take_tallies();
  Finished finished{std::move(tallies), open->second.request.repeated()};
  close(open);
  return finished;
}

void RemoteRequests::close(std::map<RequestId, Open>::iterator open) {
  for (const GenerationId portion : open->second.portions) {
    flight_.end(portion);
    portions_.erase(portion);
  }
  open_.erase(open);
}

void RemoteRequests::abandon() {
  while (!open_.empty()) {
    close(open_.begin());
  }
}

RemoteRequests::Place RemoteRequests::place_of(const Slot& slot) {
  const Portion& portion = portions_.at(slot.generation);
  return {open_.at(portion.request).request, portion.first + slot.index};
}

std::uint64_t RemoteRequests::most_steps() const {
  std::uint64_t steps = 0;
  for (const auto& [id, open] : open_) {
    steps = std::max(steps, open.request.steps());
  }
  return steps;
}

std::uint64_t RemoteRequests::steps_at_front() const {
  const auto front = flight_.front();
  const auto portion = front ? portions_.find(*front) : portions_.begin();
  return portion == portions_.end() ? 0 : at(portion->second.request).steps();
}

Horizon RemoteRequests::horizon(std::uint32_t most) const {
  Horizon horizon{.most = most};
  for (const auto& [id, open] : open_) {
    horizon.most = std::min(horizon.most, open.request.most_per_task());
    horizon.coming += open.request.unseen();
  }
  return horizon;
}

}  // namespace coppice
