// What goes out: to a worker, home, apart, and once more.
#include <algorithm>
#include <tuple>
#include <utility>

#include "common/check.hpp"
#include "coordinator/dispatch/in_flight.hpp"
#include "coordinator/dispatch/mutation.hpp"

namespace coppice {
namespace {

using namespace std::chrono_literals;

// A batch of a worker whose pace is not known is overdue when an idle worker would have done it so many times over.
constexpr int kUnknownFactor = 4;
constexpr auto kUnknownPatience = 50ms;  // but not before
constexpr int kCopyGain = 2;  // times sooner that a copy must be done than its original, to be worth its while

}  // namespace

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
  out.work = requests_.at(range.request).work;
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

}  // namespace coppice
