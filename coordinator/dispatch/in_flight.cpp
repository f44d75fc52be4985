#include "coordinator/dispatch/in_flight.hpp"

#include <algorithm>
#include <utility>

#include "common/check.hpp"

namespace coppice {
namespace {

using namespace std::chrono_literals;

// A batch of a worker whose pace is not known is overdue when an idle worker would have done it so many times over.
constexpr int kUnknownFactor = 4;
constexpr auto kUnknownPatience = 50ms;  // but not before
constexpr int kCopyGain = 2;  // times sooner that a copy must be done than its original, to be worth its while

}  // namespace

GenerationId InFlight::begin(std::uint32_t slots) {
  doubled_ = doubled_ && !done();
  const GenerationId id{next_generation_++};
  generations_.emplace(id, Generation{std::vector<bool>(slots, false), std::vector<std::uint32_t>(slots, 0), slots});
  unsettled_ += slots;
  if (slots > 0) {
    queue_.push_back({id, 0, slots, false});
    waiting_ += slots;
  }
  return id;
}

void InFlight::end(GenerationId id) {
  const auto generation = generations_.find(id);
  COPPICE_CHECK(generation != generations_.end());
  unsettled_ -= generation->second.unsettled;
  generations_.erase(generation);
  for (auto range = queue_.begin(); range != queue_.end();) {
    if (range->generation == id) {
      waiting_ -= range->count;
      range = queue_.erase(range);
    } else {
      ++range;
    }
  }
  for (auto entry = out_.begin(); entry != out_.end();) {
    const bool forgotten = entry->second.lost && entry->second.batch.generation == id;
    entry = forgotten ? out_.erase(entry) : std::next(entry);
  }
}

InFlight::Generation* InFlight::generation_of(const Batch& batch) {
  const auto found = generations_.find(batch.generation);
  return found == generations_.end() ? nullptr : &found->second;
}

const InFlight::Generation* InFlight::generation_of(const Batch& batch) const {
  const auto found = generations_.find(batch.generation);
  return found == generations_.end() ? nullptr : &found->second;
}

std::optional<GenerationId> InFlight::front() const {
  return queue_.empty() ? std::nullopt : std::optional(queue_.front().generation);
}

void InFlight::add_worker(WorkerId worker, std::size_t lanes) {
  COPPICE_CHECK(lanes >= 1);
  workers_.emplace(worker, Worker{.lanes = lanes});
  for (auto& [id, out] : out_) {
    if (out.worker != worker || !std::exchange(out.suspected, false)) {
      continue;
    }
    if (Generation* const generation = generation_of(out.batch); generation != nullptr) {
      for (std::uint32_t slot = out.batch.first; slot < out.batch.first + out.batch.count; ++slot) {
        --generation->attempts[slot];
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
  return found == workers_.end() ? 0 : found->second.slots;
}

InFlight::Duration InFlight::remaining(WorkerId worker, Time now, Duration each) const {
  const auto found = workers_.find(worker);
  if (found == workers_.end() || found->second.slots == 0) {
    return Duration(0);
  }
  const Worker& at = found->second;
  const auto work = each * at.slots / static_cast<std::int64_t>(at.lanes);
  return std::max(at.since + work - now, Duration(0));
}

std::set<WorkerId> InFlight::late(Time now) const {
  std::set<WorkerId> workers;
  for (const auto& [id, out] : out_) {
    if (!out.lost && out.due <= now) {
      workers.insert(out.worker);
    }
  }
  return workers;
}

bool InFlight::may_take(const Worker& worker, const Range& range) const {
  return !worker.alone && worker.out < (range.alone ? 1 : worker.lanes + limits_.ahead);
}

bool InFlight::can_take(WorkerId worker) const {
  const auto found = workers_.find(worker);
  return found != workers_.end() &&
         std::any_of(queue_.begin(), queue_.end(), [&](const Range& range) { return may_take(found->second, range); });
}

std::optional<InFlight::Range> InFlight::take_range(const Worker& worker, std::uint32_t most) {
  const auto found =
      std::find_if(queue_.begin(), queue_.end(), [&](const Range& range) { return may_take(worker, range); });
  if (found == queue_.end()) {
    return std::nullopt;
  }
  const Range taken{found->generation, found->first, std::min(found->count, most), found->alone};
  found->first += taken.count;
  found->count -= taken.count;
  if (found->count == 0) {
    queue_.erase(found);
  }
  waiting_ -= taken.count;
  return taken;
}

Batch InFlight::send(Worker& worker, WorkerId id, const Range& range, Time now, const Terms& terms) {
  const Batch batch{BatchId{next_batch_++}, range.generation, range.first, range.count};
  Out out;
  out.batch = batch;
  out.worker = id;
  out.sent = now;
  out.due = now + terms.patience;
  if (terms.each.count() > 0) {
    out.expected = now + remaining(id, now, terms.each) + terms.each * range.count;
  }
  out.alone = range.alone;
  out_.emplace(batch.id, out);
  worker.since = worker.out == 0 ? now : worker.since;
  ++worker.out;
  worker.slots += range.count;
  worker.alone = worker.alone || range.alone;
  return batch;
}

std::optional<Batch> InFlight::offer(WorkerId worker, std::uint32_t most, Time now, const Terms& terms) {
  COPPICE_CHECK(most >= 1);
  const auto found = workers_.find(worker);
  COPPICE_CHECK(found != workers_.end());
  const auto range = take_range(found->second, most);
  if (!range) {
    return std::nullopt;
  }
  return send(found->second, worker, *range, now, terms);
}

bool InFlight::has_unsettled(const Out& out) const {
  const Generation* const generation = generation_of(out.batch);
  if (generation == nullptr) {
    return false;
  }
  const auto begin = generation->settled.begin() + out.batch.first;
  return std::find(begin, begin + out.batch.count, false) != begin + out.batch.count;
}

bool InFlight::can_be_copied(const Out& out) const {
  return !out.lost && out.copies < limits_.copies && has_unsettled(out);
}

bool InFlight::is_held_elsewhere(const Slot& slot) const {
  return std::any_of(out_.begin(), out_.end(), [&](const auto& entry) {
    const Out& out = entry.second;
    return out.batch.generation == slot.generation && !out.lost && slot.index >= out.batch.first &&
           slot.index < out.batch.first + out.batch.count;
  });
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
  const Range range{original->batch.generation, original->batch.first, original->batch.count, original->alone};
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
  const auto worker = workers_.find(out.worker);
  if (!out.lost && worker != workers_.end()) {
    --worker->second.out;
    worker->second.slots -= out.batch.count;
    worker->second.alone = worker->second.alone && !out.alone;
  }
}

void InFlight::settle_slot(Generation& generation, std::uint32_t slot) {
  generation.settled[slot] = true;
  --generation.unsettled;
  --unsettled_;
}

std::optional<InFlight::Found> InFlight::find(BatchId batch, WorkerId worker) const {
  const auto found = out_.find(batch);
  if (found == out_.end() || found->second.worker != worker) {
    return std::nullopt;
  }
  return Found{found->second.batch, generation_of(found->second.batch) != nullptr, found->second.sent};
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
  Generation* const generation = generation_of(out.batch);
  if (generation == nullptr) {
    return settlement;
  }
  for (std::uint32_t slot = out.batch.first; slot < out.batch.first + out.batch.count; ++slot) {
    if (!generation->settled[slot]) {
      settle_slot(*generation, slot);
      settlement.fresh.push_back(slot);
      settlement.kind = Settled::first;
    }
  }
  if (doubled_) {
    drop_settled();
  }
  return settlement;
}

void InFlight::drop_settled() {
  std::deque<Range> queue;
  queue.swap(queue_);
  waiting_ = 0;
  for (const Range& range : queue) {
    const std::vector<bool>& settled = generations_.at(range.generation).settled;
    std::uint32_t run = 0;
    for (std::uint32_t slot = range.first; slot < range.first + range.count; ++slot) {
      run = settled[slot] ? 0 : run + 1;
      if (run == 1) {
        queue_.push_back({range.generation, slot, 1, range.alone});
      } else if (run > 1) {
        ++queue_.back().count;
      }
      waiting_ += run > 0 ? 1 : 0;
    }
  }
}

void InFlight::push_waiting(const Range& range) {
  queue_.push_front(range);
  waiting_ += range.count;
}

void InFlight::wait_again(const Out& out) {
  const GenerationId id = out.batch.generation;
  const Generation& generation = generations_.at(id);
  // From the back, so that the slots stand at the front of the queue in their order.
  std::uint32_t run = 0;
  const std::uint32_t end = out.batch.first + out.batch.count;
  for (std::uint32_t slot = end; slot-- > out.batch.first;) {
    const bool waits = !generation.settled[slot];
    const bool alone = waits && generation.attempts[slot] >= limits_.isolate_after;
    if (waits && !alone) {
      ++run;
      continue;
    }
    if (run > 0) {
      push_waiting({id, slot + 1, run, false});
      run = 0;
    }
    if (alone) {
      push_waiting({id, slot, 1, true});
    }
  }
  if (run > 0) {
    push_waiting({id, out.batch.first, run, false});
  }
}

bool InFlight::give_back(BatchId batch, WorkerId worker) {
  const auto found = out_.find(batch);
  if (found == out_.end() || found->second.worker != worker) {
    return false;
  }
  const Out out = found->second;
  discharge(out);
  out_.erase(found);
  if (!out.lost && generation_of(out.batch) != nullptr) {
    wait_again(out);
  }
  return true;
}

InFlight::Loss InFlight::lose_worker(WorkerId worker, Farewell farewell) {
  Loss loss;
  if (workers_.erase(worker) == 0) {
    return loss;
  }
  for (auto entry = out_.begin(); entry != out_.end();) {
    Out& out = entry->second;
    if (out.worker != worker || out.lost) {
      ++entry;
      continue;
    }
    Generation* const generation = generation_of(out.batch);
    if (generation == nullptr) {
      entry = out_.erase(entry);
      continue;
    }
    ++entry;
    out.lost = true;
    doubled_ = true;
    ++loss.batches;
    out.suspected = farewell == Farewell::died;
    for (std::uint32_t slot = out.batch.first; out.suspected && slot < out.batch.first + out.batch.count; ++slot) {
      ++generation->attempts[slot];
      if (!generation->settled[slot] && generation->attempts[slot] >= limits_.attempts &&
          !is_held_elsewhere({out.batch.generation, slot})) {
        settle_slot(*generation, slot);
        loss.poisonous.push_back({out.batch.generation, slot});
      }
    }
    wait_again(out);
  }
  return loss;
}

}  // namespace coppice
