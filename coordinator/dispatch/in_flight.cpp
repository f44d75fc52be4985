#include "coordinator/dispatch/in_flight.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

#include "common/check.hpp"
#include "coordinator/dispatch/mutation.hpp"

namespace coppice {
namespace {

using namespace std::chrono_literals;

// A batch of a worker whose pace is not known is overdue when an idle worker would have done it so many times over.
constexpr int kUnknownFactor = 4;
constexpr auto kUnknownPatience = 50ms;  // but not before
constexpr int kCopyGain = 2;  // times sooner that a copy must be done than its original, to be worth its while

}  // namespace

void InFlight::open(RequestId id, std::uint32_t most_per_batch) {
  COPPICE_CHECK(most_per_batch >= 1);
  doubled_ = doubled_ && !done();
  const auto [request, fresh] = requests_.try_emplace(id);
  COPPICE_CHECK(fresh);
  request->second.most_per_batch = most_per_batch;
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

bool InFlight::may_take(WorkerId id, const Worker& worker, const Range& range) const {
  if (worker.alone || (isolated_waiting_ > 0 && kept_free_ == id && !range.alone)) {
    return false;
  }
  return worker.out < (range.alone ? 1 : worker.lanes + limits_.ahead);
}

bool InFlight::can_take(WorkerId worker) const {
  const auto found = workers_.find(worker);
  return found != workers_.end() && std::any_of(queue_.begin(), queue_.end(), [&](const Range& range) {
           return may_take(worker, found->second, range);
         });
}

void InFlight::keep_one_free(const std::vector<Candidate>& workers) {
  const auto is_there = [&](WorkerId id) {
    return std::any_of(workers.begin(), workers.end(), [id](const Candidate& at) { return at.worker == id; });
  };
  if (isolated_waiting_ == 0 || workers.empty() || COPPICE_MUTATED(isolated_units_starve)) {
    kept_free_.reset();
    return;
  }
  // A worker that should have answered already may never do so: what it was sent, or its answer, may be lost.
  const auto is_late = [&](const Candidate& at) { return load(at.worker) > 0 && at.remaining <= Duration(0); };
  const auto key = [&](const Candidate& at) {
    return std::tuple(is_late(at), load(at.worker) > 0, at.remaining, load(at.worker));
  };
  const Candidate best = *std::min_element(workers.begin(), workers.end(),
                                           [&](const Candidate& a, const Candidate& b) { return key(a) < key(b); });
  if (kept_free_ && is_there(*kept_free_)) {
    const auto kept =
        std::find_if(workers.begin(), workers.end(), [this](const Candidate& at) { return at.worker == *kept_free_; });
    if (!is_late(*kept) || load(best.worker) > 0) {
      return;  // others may be free sooner by now, and would be filled up in their turn
    }
  }
  kept_free_ = best.worker;
}

void InFlight::forget_waiting(const Range& range) {
  waiting_ -= range.count;
  isolated_waiting_ -= range.alone ? range.count : 0;
}

std::optional<InFlight::Range> InFlight::take_range(WorkerId id, const Worker& worker, std::uint32_t most) {
  const auto found =
      std::find_if(queue_.begin(), queue_.end(), [&](const Range& range) { return may_take(id, worker, range); });
  if (found == queue_.end()) {
    return std::nullopt;
  }
  most = std::min(most, requests_.at(found->request).most_per_batch);
  const Range taken{found->request, found->first, std::min(found->count, most), found->alone};
  found->first += taken.count;
  found->count -= taken.count;
  if (found->count == 0) {
    queue_.erase(found);
  }
  forget_waiting(taken);
  if (taken.alone && kept_free_ == id) {
    kept_free_.reset();
  }
  return taken;
}

Batch InFlight::send(Worker& worker, WorkerId id, const Range& range, Time now, const Terms& terms) {
  const Batch batch{BatchId{next_batch_++}, range.request, range.first, range.count};
  Out out;
  out.batch = batch;
  out.worker = id;
  out.sent = now;
  out.due = now + terms.patience;
  out.patience = terms.patience;
  if (terms.each.count() > 0) {
    out.expected = now + remaining(id, now, terms.each) + terms.each * range.count;
  }
  out.alone = range.alone;
  out_.emplace(batch.id, out);
  worker.since = worker.out == 0 ? now : worker.since;
  ++worker.out;
  worker.units += range.count;
  worker.alone = worker.alone || range.alone;
  return batch;
}

std::optional<Batch> InFlight::offer(WorkerId worker, std::uint32_t most, Time now, const Terms& terms) {
  COPPICE_CHECK(most >= 1);
  const auto found = workers_.find(worker);
  COPPICE_CHECK(found != workers_.end());
  const auto range = take_range(worker, found->second, most);
  if (!range) {
    return std::nullopt;
  }
  return send(found->second, worker, *range, now, terms);
}

Batch InFlight::keep_home(const Range& range, Time now) {
  Out out;
  out.batch = {BatchId{next_batch_++}, range.request, range.first, range.count};
  out.worker = kHome;
  out.sent = now;
  out.due = Time::max();
  out.alone = range.alone;
  out.copies = limits_.copies;  // home keeps its word
  out_.emplace(out.batch.id, out);
  return out.batch;
}

std::optional<Batch> InFlight::offer_home(RequestId request, std::uint32_t most, Time now) {
  const auto found = std::find_if(queue_.begin(), queue_.end(),
                                  [&](const Range& range) { return range.request == request && !range.alone; });
  if (found == queue_.end()) {
    return std::nullopt;
  }
  const Range taken{found->request, found->first, std::min(found->count, most), false};
  found->first += taken.count;
  found->count -= taken.count;
  if (found->count == 0) {
    queue_.erase(found);
  }
  forget_waiting(taken);
  return keep_home(taken, now);
}

std::optional<Batch> InFlight::offer_apart(Time now) {
  if (apart_.empty()) {
    return std::nullopt;
  }
  const Unit unit = apart_.front();
  apart_.pop_front();
  return keep_home({unit.request, unit.index, 1, true}, now);
}

InFlight::Overdue InFlight::offer_overdue_again(Time now) {
  Overdue overdue;
  if (waiting_ == 0) {
    return overdue;
  }
  for (auto& [id, out] : out_) {
    if (can_be_copied(out) && out.due + std::max<Duration>(out.patience, kGrace) <= now) {
      out.copies = limits_.copies;
      doubled_ = true;
      Loss again;
      wait_again(out, again);
      ++overdue.batches;
      overdue.units += again.units;
    }
  }
  return overdue;
}

bool InFlight::has_unsettled(const Out& out) const {
  const Request* const request = request_of(out.batch);
  if (request == nullptr) {
    return false;
  }
  const auto begin = request->settled.begin() + out.batch.first;
  return std::find(begin, begin + out.batch.count, false) != begin + out.batch.count;
}

bool InFlight::can_be_copied(const Out& out) const {
  return !out.lost && out.copies < limits_.copies && has_unsettled(out);
}

InFlight::Out* InFlight::worth_a_copy(WorkerId worker, Time now, Duration each) {
  Out* overdue = nullptr;
  Out* last = nullptr;
  for (auto& [id, out] : out_) {
    if (out.worker == worker || !can_be_copied(out)) {
      continue;
    }
    const bool stranger_late =
        !out.expected && each.count() > 0 && out.copies == 0 &&
        out.sent + std::max<Duration>(kUnknownPatience, kUnknownFactor * each * out.batch.count) <= now;
    if ((out.due <= now || stranger_late) && (overdue == nullptr || out.due < overdue->due)) {
      overdue = &out;
    }
    if (out.expected && each.count() > 0 && now + kCopyGain * each * out.batch.count < *out.expected &&
        (last == nullptr || *out.expected > *last->expected)) {
      last = &out;
    }
  }
  return overdue != nullptr ? overdue : last;
}

std::optional<Batch> InFlight::offer_copy(WorkerId worker, Time now, const Terms& terms) {
  const auto found = workers_.find(worker);
  COPPICE_CHECK(found != workers_.end());
  if (waiting_ > 0 || found->second.out >= found->second.lanes || found->second.alone) {
    return std::nullopt;
  }
  Out* const original = worth_a_copy(worker, now, terms.each);
  if (original == nullptr) {
    return std::nullopt;
  }
  doubled_ = true;
  ++original->copies;
  // The copy gets its time before a third worker is asked.
  original->due = std::max(original->due, now + terms.patience);
  original->expected.reset();
  const Range range{original->batch.request, original->batch.first, original->batch.count, original->alone};
  const Batch copy = send(found->second, worker, range, now, terms);
  out_.at(copy.id).copies = limits_.copies;
  return copy;
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
  return Found{found->second.batch, request_of(found->second.batch) != nullptr, found->second.sent};
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

void InFlight::push_waiting(const Range& range) {
  queue_.push_front(range);
  waiting_ += range.count;
  isolated_waiting_ += range.alone ? range.count : 0;
}

void InFlight::wait_again(const Out& out, Loss& loss) {
  const RequestId id = out.batch.request;
  const Request& request = requests_.at(id);
  // From the back, so that the units stand at the front of the queue in their order.
  std::uint32_t run = 0;
  const std::uint32_t end = out.batch.first + out.batch.count;
  for (std::uint32_t unit = end; unit-- > out.batch.first;) {
    Suspicion suspicion;
    if (const auto found = request.suspicions.find(unit); found != request.suspicions.end()) {
      suspicion = found->second;
    }
    const bool waits = !request.settled[unit];
    const bool apart =
        waits && (suspicion.deaths >= limits_.apart_after || suspicion.losses >= limits_.lost_before_apart ||
                  suspicion.shortages >= limits_.short_before_apart);
    const bool alone = waits && !apart && (suspicion.deaths >= limits_.isolate_after || suspicion.shortages > 0);
    loss.units += waits ? 1 : 0;
    if (waits && !alone && !apart) {
      ++run;
      continue;
    }
    if (run > 0) {
      push_waiting({id, unit + 1, run, false});
      run = 0;
    }
    if (alone) {
      push_waiting({id, unit, 1, true});
    }
    if (apart && !is_apart({id, unit})) {
      apart_.push_back({id, unit});
      ++loss.apart;
    }
  }
  if (run > 0) {
    push_waiting({id, out.batch.first, run, false});
  }
}

// Waits to be computed apart, or is.
bool InFlight::is_apart(const Unit& unit) const {
  return std::find(apart_.begin(), apart_.end(), unit) != apart_.end() ||
         std::any_of(out_.begin(), out_.end(), [&unit](const auto& entry) {
           const Batch& batch = entry.second.batch;
           return entry.second.worker == kHome && batch.request == unit.request && batch.first <= unit.index &&
                  unit.index < batch.first + batch.count;
         });
}

bool InFlight::give_back(BatchId batch, WorkerId worker, Reason reason) {
  const auto found = out_.find(batch);
  if (found == out_.end() || found->second.worker != worker) {
    return false;
  }
  const Out out = found->second;
  discharge(out);
  out_.erase(found);
  Request* const request = request_of(out.batch);
  if (out.lost || request == nullptr) {
    return true;
  }
  for (std::uint32_t unit = out.batch.first; unit < out.batch.first + out.batch.count; ++unit) {
    if (reason == Reason::lacks_memory && !request->settled[unit] && !COPPICE_MUTATED(short_memory_asked_again)) {
      ++request->suspicions[unit].shortages;
    }
  }
  Loss ignored;
  if (!COPPICE_MUTATED(given_back_forgotten)) {
    wait_again(out, ignored);
  }
  return true;
}

void InFlight::suspect(Out& out, Farewell farewell, bool at_work, Loss& loss) {
  if (farewell == Farewell::left || (farewell == Farewell::died && !at_work)) {
    return;
  }
  if (COPPICE_MUTATED(losses_count_as_deaths)) {
    farewell = Farewell::died;
  }
  Request& request = *request_of(out.batch);
  out.suspected = farewell == Farewell::unreachable;
  for (std::uint32_t unit = out.batch.first; unit < out.batch.first + out.batch.count; ++unit) {
    if (request.settled[unit]) {
      continue;
    }
    Suspicion& suspicion = request.suspicions[unit];
    ++(farewell == Farewell::died ? suspicion.deaths : suspicion.losses);
    loss.suspect += farewell == Farewell::died ? 1 : 0;
    if (COPPICE_MUTATED(lost_units_invented) && suspicion.losses >= 5) {
      settle_unit(request, unit);
    }
  }
}

InFlight::Loss InFlight::lose_worker(WorkerId worker, Farewell farewell) {
  Loss loss;
  const auto at = workers_.find(worker);
  if (at == workers_.end()) {
    return loss;
  }
  const std::size_t lanes = at->second.lanes;
  workers_.erase(at);
  if (kept_free_ == worker) {
    kept_free_.reset();
  }
  std::size_t before = 0;  // batches that it had got earlier: a lane takes them in that order
  for (auto entry = out_.begin(); entry != out_.end();) {
    Out& out = entry->second;
    if (out.worker != worker || out.lost) {
      ++entry;
      continue;
    }
    const bool at_work = before++ < lanes;
    if (request_of(out.batch) == nullptr) {
      entry = out_.erase(entry);
      continue;
    }
    ++entry;
    out.lost = true;
    doubled_ = true;
    ++loss.batches;
    suspect(out, farewell, at_work, loss);
    if (!COPPICE_MUTATED(lost_batches_forgotten)) {
      wait_again(out, loss);
    }
  }
  return loss;
}

}  // namespace coppice
