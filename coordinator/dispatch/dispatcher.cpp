#include "coordinator/dispatch/dispatcher.hpp"

#include <algorithm>
#include <utility>

#include "common/check.hpp"
#include "coordinator/dispatch/mutation.hpp"
#include "coordinator/dispatch/schedule.hpp"

namespace coppice {
namespace {

using namespace std::chrono_literals;

constexpr auto kTendInterval = 100ms;  // silence, hangs and limits are looked at this often
constexpr auto kFirstHangLimit = 5s;   // no progress with work at hand for this long; doubled each time
constexpr std::size_t kMostApart = 1;  // processes that compute a unit apart at a time

}  // namespace

Dispatcher::Dispatcher(const DispatchSettings& settings)
    : settings_(settings),
      flight_(settings.limits),
      cross_check_(settings.cross_check, settings.seed),
      places_(settings.places),
      hang_limit_(kFirstHangLimit) {}

RequestId Dispatcher::open(const RequestTerms& terms, Time now) {
  if (requests_.empty()) {
    last_settled_ = roster_.listened();
  }
  if (begun_ >= requests_.size()) {
    begun_ = 0;
    hang_limit_ = kFirstHangLimit;
    without_worker_since_.reset();
    for (auto& [id, worker] : roster_.all()) {
      // A worker that is at work will show its pace by its answer. Demes open requests all the time: if each request
      // made the paces of busy workers shorter, their epochs would count as overdue and be computed twice.
      if (flight_.load(id) == 0) {
        worker.pace.doubt(now);
      }
    }
  }
  ++begun_;
  const RequestId id{next_request_++};
  OpenRequest& request = requests_[id];
  request.terms = terms;
  request.begun = now;
  flight_.open(id, terms.most_per_batch, terms.work);
  return id;
}

void Dispatcher::add(RequestId id, std::uint32_t units) {
  OpenRequest& request = requests_.at(id);
  COPPICE_CHECK(!request.sealed);
  request.outcomes.resize(request.outcomes.size() + units);
  request.believed.resize(request.outcomes.size(), kHome);
  flight_.add(id, units);
}

void Dispatcher::seal(RequestId id) { requests_.at(id).sealed = true; }

bool Dispatcher::done(RequestId id) const {
  const OpenRequest& request = requests_.at(id);
  return (request.sealed || COPPICE_MUTATED(growing_requests_end_early)) &&
         (request.undecided == 0 || COPPICE_MUTATED(samples_not_waited_for)) && flight_.done(id);
}

Dispatcher::Finished Dispatcher::take(RequestId id) {
  COPPICE_CHECK(done(id));
  const auto request = requests_.find(id);
  Finished finished{std::move(request->second.outcomes), request->second.repeated};
  close(request);
  return finished;
}

void Dispatcher::close(OpenRequests::iterator request) {
  flight_.close(request->first);
  requests_.erase(request);
}

void Dispatcher::abandon() {
  while (!requests_.empty()) {
    for (const WorkerId worker : requests_.begin()->second.believed) {
      cross_check_.forget_unchecked(worker, 1);
    }
    close(requests_.begin());
  }
  // An answer that waits for its sample has come: its worker's credit is free again.
  for (const auto& [id, purpose] : computing_) {
    if (const auto* const examination = std::get_if<Examination>(&purpose)) {
      flight_.settle(examination->answer.batch, examination->answer.worker, now_);
    }
  }
  computing_.clear();
  apart_ = 0;
}

bool Dispatcher::somebody_takes(const WorkClass& work, std::chrono::nanoseconds each) const {
  const auto& workers = roster_.all();
  return std::any_of(workers.begin(), workers.end(),
                     [&](const auto& entry) { return entry.second.pace.each(work) >= each; });
}

std::size_t Dispatcher::ready_lanes() const {
  std::size_t lanes = 0;
  for (const auto& [id, worker] : roster_.all()) {
    lanes += worker.ready() ? worker.lanes : 0;
  }
  return lanes;
}

DispatchStatistics Dispatcher::statistics() const {
  DispatchStatistics statistics = statistics_;
  statistics.workers_alive = roster_.ready();
  for (const auto& [id, request] : requests_) {
    const bool open = request.terms.work.kind == WorkKind::evolve && !flight_.done(id);
    statistics.epochs_open += open ? 1 : 0;
  }
  bool first = true;
  for (const auto& [id, worker] : roster_.all()) {
    if (worker.ready()) {
      const std::size_t held = flight_.load(id);
      statistics.fewest_held = first ? held : std::min(statistics.fewest_held, held);
      statistics.most_held = std::max(statistics.most_held, held);
      first = false;
    }
  }
  return statistics;
}

void Dispatcher::fail(Error error, std::optional<Unit> deadly) {
  if (!actions_.failure) {
    actions_.failure = Failure{std::move(error), deadly};
  }
}

Actions Dispatcher::step(std::span<DispatchEvent> events, Time now) {
  roster_.listen(now);
  now_ = now;
  actions_ = {};
  for (DispatchEvent& event : events) {
    std::visit([this](auto& happened) { on(happened); }, event);
  }
  if (now >= next_tending_) {
    next_tending_ = now + kTendInterval;
    tend();
  }
  if (!actions_.failure) {
    compute_apart();
    hand_out();
  }
  actions_.wake_at = next_tending_;
  if (const auto due = flight_.next_due(); due && *due > now) {
    actions_.wake_at = std::min(actions_.wake_at, *due);
  }
  return std::move(actions_);
}

void Dispatcher::hand_out() {
  if (flight_.done()) {
    return;
  }
  // What is out of other classes of work may be reckoned a little wrong by this, which costs time only.
  const auto front = flight_.front();
  const WorkClass work = requests_.at(front ? *front : requests_.begin()->first).terms.work;
  std::uint32_t coming = 0;
  for (const auto& [id, request] : requests_) {
    coming += request.coming();
  }
  std::vector<ReadyWorker> ready;
  ready.reserve(roster_.all().size());
  for (const auto& [id, worker] : roster_.all()) {
    if (worker.ready() && worker.rests_until <= roster_.listened()) {
      ready.push_back({id, {worker.lanes, worker.pace.each(work)}});
    }
  }
  for (const Assignment& assignment : next_assignments(flight_, ready, coming, now_)) {
    roster_.find(assignment.worker)->progressed = roster_.listened();
    actions_.actions.emplace_back(SendTask{assignment.worker, assignment.batch, assignment.copy});
    ++statistics_.batches;
    statistics_.copies += assignment.copy ? 1 : 0;
  }
}

void Dispatcher::compute_apart() {
  while (apart_ < kMostApart) {
    const auto batch = flight_.offer_apart(now_);
    if (!batch) {
      return;
    }
    ++apart_;
    say(Say::Level::warn, "an individual is evaluated in a process of its own: too many workers were lost with it");
    compute(batch->request, {batch->first}, true, AtHome{batch->id, true});
  }
}

ComputeId Dispatcher::compute(RequestId request, std::vector<std::uint32_t> units, bool apart, Purpose purpose) {
  const ComputeId id{next_compute_++};
  computing_.emplace(id, std::move(purpose));
  actions_.actions.emplace_back(Compute{id, request, std::move(units), apart});
  return id;
}

}  // namespace coppice
