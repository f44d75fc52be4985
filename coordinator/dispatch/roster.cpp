#include "coordinator/dispatch/roster.hpp"

#include <algorithm>

#include "common/check.hpp"
#include "coordinator/dispatch/mutation.hpp"

namespace coppice {

void Roster::listen(InFlight::Time now) {
  COPPICE_CHECK(!last_ || now >= *last_);
  if (last_) {
    const std::chrono::nanoseconds passed = now - *last_;
    listened_ +=
        COPPICE_MUTATED(silence_while_absent) ? passed : std::min<std::chrono::nanoseconds>(passed, kMostListened);
  }
  last_ = now;
}

KnownWorker* Roster::find(WorkerId id) {
  const auto found = workers_.find(id);
  return found == workers_.end() ? nullptr : &found->second;
}

const KnownWorker* Roster::find(WorkerId id) const {
  const auto found = workers_.find(id);
  return found == workers_.end() ? nullptr : &found->second;
}

std::size_t Roster::ready() const {
  return static_cast<std::size_t>(
      std::count_if(workers_.begin(), workers_.end(), [](const auto& entry) { return entry.second.ready(); }));
}

Roster::Speaker Roster::speaker(WorkerId name, const std::optional<Origin>& origin) const {
  if (!origin) {
    return Speaker::unknown;
  }
  const auto known = names_.find(name);
  if (known == names_.end()) {
    return Speaker::first;
  }
  return known->second == *origin ? Speaker::own : Speaker::other;
}

KnownWorker& Roster::meet(const HelloHeard& hello) {
  COPPICE_CHECK(!full() && hello.origin);
  KnownWorker worker;
  worker.origin = *hello.origin;
  worker.name = hello.name;
  worker.pid = hello.pid;
  worker.here = hello.here;
  worker.lanes = std::clamp<std::size_t>(hello.lanes, 1, kMaxLanes);
  worker.progressed = listened_;
  names_.emplace(hello.worker, *hello.origin);
  const auto [entry, fresh] = workers_.emplace(hello.worker, std::move(worker));
  COPPICE_CHECK(fresh);
  return entry->second;
}

void Roster::hear(KnownWorker& worker, const HelloHeard& hello) {
  worker.heard = listened_;
  if (hello.evaluated != worker.evaluated) {
    worker.evaluated = hello.evaluated;
    worker.progressed = listened_;
  }
  worker.serves = hello.serves;
  worker.holds_chain = hello.holds_chain;
}

void Roster::let_go(WorkerId id) {
  if (workers_.erase(id) == 0) {
    return;
  }
  if (COPPICE_MUTATED(names_are_forgotten)) {
    names_.erase(id);
    return;
  }
  departed_.push_back(id);
  while (departed_.size() > kMaxRemembered) {
    if (workers_.count(departed_.front()) == 0) {
      names_.erase(departed_.front());
    }
    departed_.pop_front();
  }
}

std::vector<WorkerId> Roster::silent() const {
  std::vector<WorkerId> silent;
  for (const auto& [id, worker] : workers_) {
    if (listened_ - worker.heard > kSilence) {
      silent.push_back(id);
    }
  }
  return silent;
}

void Roster::ban(WorkerId id) {
  if (banned_.size() < kMaxRemembered) {
    banned_.insert(id);
  }
}

}  // namespace coppice
