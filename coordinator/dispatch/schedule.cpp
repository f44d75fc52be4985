#include "coordinator/dispatch/schedule.hpp"

#include <algorithm>
#include <chrono>
#include <set>
#include <tuple>

#include "common/check.hpp"

namespace coppice {
namespace {

using namespace std::chrono_literals;

constexpr auto kShortestPatience = 25ms;  // a batch is not overdue before
constexpr auto kLongestPatience = 60s;
constexpr auto kPatienceUnmeasured = 2s;
constexpr int kPatienceFactor = 4;  // times the measured cost of all that the worker has before it

InFlight::Terms terms_for(const ReadyWorker& worker, std::uint32_t backlog, std::uint32_t units) {
  if (worker.pace.each.count() == 0) {
    return {.patience = kPatienceUnmeasured, .each = {}};
  }
  const double work = static_cast<double>(worker.pace.each.count()) *
                      (static_cast<double>(backlog) + static_cast<double>(units)) * kPatienceFactor;
  const double longest = static_cast<double>(std::chrono::nanoseconds(kLongestPatience).count());
  const std::chrono::nanoseconds patience(static_cast<std::int64_t>(std::min(work, longest)));
  return {.patience = std::max<std::chrono::nanoseconds>(kShortestPatience, patience), .each = worker.pace.each};
}

FleetPace fleet_pace(const InFlight& flight, std::span<const ReadyWorker> workers, const std::set<WorkerId>& late,
                     InFlight::Time now) {
  FleetPace fleet;
  for (const ReadyWorker& worker : workers) {
    if (late.count(worker.id) == 0) {
      fleet.add(worker.pace, flight.remaining(worker.id, now, worker.pace.each));
    }
  }
  return fleet;
}

struct Offer {
  const ReadyWorker* worker = nullptr;
  std::chrono::nanoseconds remaining{0};
  std::size_t load = 0;
  std::uint32_t units = 0;
  bool late = false;
};

// To whom the next batch should go: of those that would be done in time with one more, the first to be free. A worker
// that should have answered already may never do so, so it is asked last.
Offer next_offer(const InFlight& flight, std::span<const ReadyWorker> workers, const FleetPace& fleet,
                 const std::set<WorkerId>& late, InFlight::Time now, double end) {
  Offer next;
  for (const ReadyWorker& worker : workers) {
    if (!flight.can_take(worker.id)) {
      continue;
    }
    const auto remaining = flight.remaining(worker.id, now, worker.pace.each);
    const std::size_t load = flight.load(worker.id);
    const bool is_late = late.count(worker.id) != 0;
    if (next.worker != nullptr &&
        std::tie(is_late, remaining, load) >= std::tie(next.late, next.remaining, next.load)) {
      continue;
    }
    const std::uint32_t units = batch_size({.waiting = flight.waiting(),
                                            .end = end,
                                            .fastest = fleet.fastest(),
                                            .worker = worker.pace,
                                            .remaining = remaining});
    if (units > 0) {
      next = {&worker, remaining, load, units, is_late};
    }
  }
  return next;
}

}  // namespace

std::vector<Assignment> next_assignments(InFlight& flight, std::span<const ReadyWorker> workers, std::uint32_t coming,
                                         InFlight::Time now) {
  std::vector<Assignment> assignments;
  if (flight.isolated_waits()) {
    std::vector<InFlight::Candidate> candidates;
    candidates.reserve(workers.size());
    for (const ReadyWorker& worker : workers) {
      candidates.push_back({worker.id, flight.remaining(worker.id, now, worker.pace.each)});
    }
    flight.keep_one_free(candidates);
  }
  if (flight.waiting() > 0) {
    const auto late = flight.late(now);
    const FleetPace fleet = fleet_pace(flight, workers, late, now);
    // Stays as it is while units move from waiting to pending.
    const double end = fleet.known() ? fleet.end(flight.waiting() + coming) : 0.0;
    while (flight.waiting() > 0) {
      const Offer next = next_offer(flight, workers, fleet, late, now, end);
      if (next.worker == nullptr) {
        break;
      }
      const WorkerId id = next.worker->id;
      const auto terms = terms_for(*next.worker, flight.backlog(id), next.units);
      const auto batch = flight.offer(id, next.units, now, terms);
      COPPICE_CHECK(batch.has_value());  // can_take()
      assignments.push_back({id, *batch, false});
    }
  }
  if (flight.waiting() == 0 && coming == 0 && !flight.done()) {
    for (const ReadyWorker& worker : workers) {
      const auto terms = terms_for(worker, flight.backlog(worker.id), flight.unsettled());
      if (const auto copy = flight.offer_copy(worker.id, now, terms)) {
        assignments.push_back({worker.id, *copy, true});
      }
    }
  }
  return assignments;
}

}  // namespace coppice
