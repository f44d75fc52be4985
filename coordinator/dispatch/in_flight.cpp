#include "coordinator/dispatch/in_flight.hpp"

#include <algorithm>
#include <utility>

#include "common/check.hpp"
#include "coordinator/dispatch/mutation.hpp"

namespace coppice {

void InFlight::open(RequestId id, std::uint32_t most_per_batch, const WorkClass& work) {
  COPPICE_CHECK(most_per_batch >= 1);
  doubled_ = doubled_ && !done();
  const auto [request, fresh] = requests_.try_emplace(id);
  COPPICE_CHECK(fresh);
  request->second.most_per_batch = most_per_batch;
  request->second.work = work;
}

void InFlight::add(RequestId id, std::uint32_t units) {
  Request& request = requests_.at(id);
  const auto first = static_cast<std::uint32_t>(request.settled.size());
  request.settled.resize(first + units, false);
  request.unsettled += units;
  unsettled_ += units;
  if (units > 0) {
    queue_.push_back({id, first, units, false});
    waiting_ += units;
  }
}

void InFlight::close(RequestId id) {
  const auto request = requests_.find(id);
  COPPICE_CHECK(request != requests_.end());
  unsettled_ -= request->second.unsettled;
  requests_.erase(request);
  for (auto range = queue_.begin(); range != queue_.end();) {
    if (range->request == id) {
      forget_waiting(*range);
      if (COPPICE_MUTATED(isolation_outlives_requests)) {
        isolated_waiting_ += range->alone ? range->count : 0;
      }
      range = queue_.erase(range);
    } else {
      ++range;
    }
  }
  std::erase_if(apart_, [id](const Unit& unit) { return unit.request == id; });
  std::erase_if(out_, [id](const auto& entry) {
    return entry.second.batch.request == id && (entry.second.lost || entry.second.worker == kHome);
  });
  if (COPPICE_MUTATED(batch_numbers_again) && requests_.empty()) {
    next_batch_ = 1;
  }
}

InFlight::Request* InFlight::request_of(const Batch& batch) {
  const auto found = requests_.find(batch.request);
  return found == requests_.end() ? nullptr : &found->second;
}

const InFlight::Request* InFlight::request_of(const Batch& batch) const {
  const auto found = requests_.find(batch.request);
  return found == requests_.end() ? nullptr : &found->second;
}

std::optional<RequestId> InFlight::front() const {
  return queue_.empty() ? std::nullopt : std::optional(queue_.front().request);
}

std::uint32_t InFlight::deaths(const Unit& unit) const {
  const auto& suspicions = requests_.at(unit.request).suspicions;
  const auto found = suspicions.find(unit.index);
  return found == suspicions.end() ? 0 : found->second.deaths;
}

void InFlight::add_worker(WorkerId worker, std::size_t lanes) {
  COPPICE_CHECK(lanes >= 1 && worker != kHome);
  workers_.emplace(worker, Worker{.lanes = lanes});
  for (auto& [id, out] : out_) {
    if (out.worker != worker || !std::exchange(out.suspected, false)) {
      continue;
    }
    if (Request* const request = request_of(out.batch); request != nullptr) {
      for (std::uint32_t unit = out.batch.first; unit < out.batch.first + out.batch.count; ++unit) {
        if (const auto found = request->suspicions.find(unit); found != request->suspicions.end()) {
          found->second.losses -= std::min(found->second.losses, 1U);
        }
      }
    }
  }
}

std::size_t InFlight::load(WorkerId worker) const {
  const auto found = workers_.find(worker);
  return found == workers_.end() ? 0 : found->second.out;
}

std::uint32_t InFlight::backlog(WorkerId worker) const {
  const auto found = workers_.find(worker);
  return found == workers_.end() ? 0 : found->second.units;
}

std::size_t InFlight::credit(WorkerId worker) const {
  const auto found = workers_.find(worker);
  return found == workers_.end() ? 0 : found->second.lanes + limits_.ahead;
}

InFlight::Duration InFlight::remaining(WorkerId worker, Time now, Duration each) const {
  const auto found = workers_.find(worker);
  if (found == workers_.end() || found->second.units == 0) {
    return Duration(0);
  }
  const Worker& at = found->second;
  const auto work = each * at.units / static_cast<std::int64_t>(at.lanes);
  return std::max(at.since + work - now, Duration(0));
}

std::set<WorkerId> InFlight::late(Time now) const {
  std::set<WorkerId> workers;
  for (const auto& [id, out] : out_) {
    if (!out.lost && out.worker != kHome && out.due <= now) {
      workers.insert(out.worker);
    }
  }
  return workers;
}

std::optional<InFlight::Time> InFlight::next_due() const {
  std::optional<Time> next;
  for (const auto& [id, out] : out_) {
    if (can_be_copied(out) && (!next || out.due < *next)) {
      next = out.due;
    }
  }
  return next;
}

void InFlight::discharge(const Out& out) {
  if (COPPICE_MUTATED(credit_never_returned) && request_of(out.batch) == nullptr) {
    return;
  }
  const auto worker = workers_.find(out.worker);
  if (!out.lost && worker != workers_.end()) {
    --worker->second.out;
    worker->second.units -= out.batch.count;
    worker->second.alone = worker->second.alone && !out.alone;
  }
}

void InFlight::settle_unit(Request& request, std::uint32_t unit) {
  request.settled[unit] = true;
  --request.unsettled;
  --unsettled_;
}

std::optional<InFlight::Found> InFlight::find(BatchId batch, WorkerId worker) const {
  const auto found = out_.find(batch);
  if (found == out_.end() || found->second.worker != worker) {
    return std::nullopt;
  }
  return Found{found->second.batch, request_of(found->second.batch) != nullptr, found->second.sent, found->second.work};
}

void InFlight::answered(BatchId batch, WorkerId worker) {
  if (const auto found = out_.find(batch); found != out_.end() && found->second.worker == worker) {
    found->second.answered = true;
  }
}

InFlight::Settlement InFlight::settle(BatchId batch, WorkerId worker, Time now) {
  const auto found = out_.find(batch);
  if (found == out_.end() || found->second.worker != worker) {
    return {};
  }
  const Out out = found->second;
  discharge(out);
  if (const auto at = workers_.find(worker); at != workers_.end()) {
    at->second.since = now;
  }
  out_.erase(found);
  Settlement settlement{Settled::duplicate, out.batch, {}};
  Request* const request = request_of(out.batch);
  if (request == nullptr) {
    return settlement;
  }
  for (std::uint32_t unit = out.batch.first; unit < out.batch.first + out.batch.count; ++unit) {
    if (!request->settled[unit] || COPPICE_MUTATED(duplicates_counted_twice)) {
      settle_unit(*request, unit);
      settlement.fresh.push_back(unit);
      settlement.kind = Settled::first;
    }
  }
  if (doubled_) {
    drop_settled();
  }
  return settlement;
}

void InFlight::drop_settled() {
  std::erase_if(apart_, [this](const Unit& unit) { return is_settled(unit); });
  std::deque<Range> queue;
  queue.swap(queue_);
  waiting_ = 0;
  isolated_waiting_ = 0;
  for (const Range& range : queue) {
    const std::vector<bool>& settled = requests_.at(range.request).settled;
    std::uint32_t run = 0;
    for (std::uint32_t unit = range.first; unit < range.first + range.count; ++unit) {
      run = settled[unit] ? 0 : run + 1;
      if (run == 1) {
        queue_.push_back({range.request, unit, 1, range.alone});
      } else if (run > 1) {
        ++queue_.back().count;
      }
      waiting_ += run > 0 ? 1 : 0;
      isolated_waiting_ += run > 0 && range.alone ? 1 : 0;
    }
  }
}

}  // namespace coppice
