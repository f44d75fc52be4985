// What comes back unanswered, and what that says about its units.
#include <algorithm>
#include <utility>

#include "coordinator/dispatch/in_flight.hpp"
#include "coordinator/dispatch/mutation.hpp"

namespace coppice {

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

void InFlight::suspect(Out& out, LossCause cause, bool at_work, Loss& loss) {
  if (cause == LossCause::left || (cause == LossCause::died && !at_work)) {
    return;
  }
  if (COPPICE_MUTATED(losses_count_as_deaths)) {
    cause = LossCause::died;
  }
  Request& request = *request_of(out.batch);
  out.suspected = cause == LossCause::unreachable;
  for (std::uint32_t unit = out.batch.first; unit < out.batch.first + out.batch.count; ++unit) {
    if (request.settled[unit]) {
      continue;
    }
    Suspicion& suspicion = request.suspicions[unit];
    ++(cause == LossCause::died ? suspicion.deaths : suspicion.losses);
    loss.suspect += cause == LossCause::died ? 1 : 0;
    if (COPPICE_MUTATED(lost_units_invented) && suspicion.losses >= 5) {
      settle_unit(request, unit);
    }
  }
}

InFlight::Loss InFlight::lose_worker(WorkerId worker, LossCause cause) {
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
    const bool answered = out.answered;
    const bool at_work = !answered && before++ < lanes;
    if (request_of(out.batch) == nullptr) {
      entry = out_.erase(entry);
      continue;
    }
    ++entry;
    out.lost = true;
    doubled_ = true;
    ++loss.batches;
    if (!answered) {
      suspect(out, cause, at_work, loss);
    }
    if (!COPPICE_MUTATED(lost_batches_forgotten)) {
      wait_again(out, loss);
    }
  }
  return loss;
}

}  // namespace coppice
