// What must be true of a dispatcher whatever happens, held against what the world knows.
#include <algorithm>
#include <cstring>
#include <fmt/format.h>

#include "tests/simulation/world.hpp"

namespace coppice::simulation {
namespace {

constexpr std::size_t kFewWorkers = 64;  // looked at after every step; more, now and then
constexpr std::uint32_t kFewUnits = 64;
constexpr std::uint64_t kNowAndThen = 64;
// After the last fault: for work of a second, and whatever limits of the dispatcher have to pass first.
constexpr Nanos kRecovery = 120 * kSecond;
constexpr Nanos kTolerance = 20;  // times the ideal

struct Word {
  std::uint64_t truth = 0;
  WorkerId liar{};
  bool operator==(const Word&) const = default;
};

UnitOutcome outcome_of(bool epoch, const Word& word) {
  if (epoch) {
    std::vector<std::uint8_t> bytes(sizeof word);
    std::memcpy(bytes.data(), &word, sizeof word);
    return bytes;
  }
  Tally tally;
  tally.steps = word.truth;
  tally.matches = static_cast<std::uint64_t>(word.liar);
  return tally;
}

// Of a slot that nobody filled: a word of nobody.
Word word_in(const UnitOutcome& outcome) {
  Word word;
  if (const auto* const bytes = std::get_if<std::vector<std::uint8_t>>(&outcome)) {
    std::memcpy(&word, bytes->data(), std::min(bytes->size(), sizeof word));
  } else {
    word = {std::get<Tally>(outcome).steps, WorkerId{std::get<Tally>(outcome).matches}};
  }
  return word;
}

std::string shown(const Unit& unit) {
  return fmt::format("unit {} of request {}", unit.index, static_cast<std::uint64_t>(unit.request));
}

}  // namespace

// A tally for an evaluation, bytes for an epoch; in both, the truth about the unit and who lies about it.
UnitOutcome World::truth(RequestId request, std::uint32_t unit) const {
  return outcome_of(is_epoch(request), {hash(scenario_.seed, 17, request, unit), WorkerId{}});
}

UnitOutcome World::lie(RequestId request, std::uint32_t unit, WorkerId liar) const {
  return outcome_of(is_epoch(request), {word_in(truth(request, unit)).truth, liar});
}

void World::check_sent(const SendTask& task) const {
  const KnownWorker* const worker = dispatcher_.roster().find(task.worker);
  if (worker == nullptr || !worker->ready() || links_.count(task.worker) == 0) {
    broken("sends", "a task to a worker that is not there, or not ready");
  }
  const auto request = dispatcher_.requests().find(task.batch.request);
  if (request == dispatcher_.requests().end() || task.batch.count == 0 ||
      task.batch.count > request->second.terms.most_per_batch ||
      task.batch.first + task.batch.count > request->second.units()) {
    broken("sends", "a task of units that there are not, or of too many");
  }
  if (dispatcher_.roster().is_banned(task.worker)) {
    broken("sends", "a task to a worker that is banned");
  }
}

// A worker that lacks memory is left alone for a second.
void World::count_shortage(std::uint32_t index) {
  Seat& seat = seats_[index];
  if (now_ - seat.shortages_since > 500 * kMillisecond) {
    seat.shortages_since = now_;
    seat.shortages = 0;
  }
  if (++seat.shortages > 4 * (scenario_.lanes + 1)) {
    broken("memory", fmt::format("{} batches in {:.3f} s to a worker that lacks the memory for them", seat.shortages,
                                 static_cast<double>(now_ - seat.shortages_since) / kSecond));
  }
}

void World::check_step(const DispatchStatistics& before) {
  const InFlight& flight = dispatcher_.flight();
  const bool look = report_.steps % kNowAndThen == 0;
  if (look || dispatcher_.roster().all().size() <= kFewWorkers) {
    for (const auto& [id, worker] : dispatcher_.roster().all()) {
      if (flight.load(id) > flight.credit(id)) {
        broken("credit", fmt::format("{} batches at a worker that may have {}", flight.load(id), flight.credit(id)));
      }
      const std::uint32_t seat = seat_of_.at(id);
      if (seats_[seat].id == id && worker.origin != origin_of(seat, seats_[seat].life)) {
        broken("names", "somebody else is known under a worker's name");
      }
      if (links_.count(id) == 0 || !flight.has_worker(id)) {
        broken("links", "a worker that is known has no link, or is not in the in-flight table");
      }
    }
    if (links_.size() != dispatcher_.roster().all().size() || flight.workers() != links_.size()) {
      broken("links", "of workers that are not known");
    }
    for (std::uint32_t index = 0; index < seats_.size(); ++index) {
      if (seats_[index].runs && liars_.count(seats_[index].id) == 0 &&
          dispatcher_.roster().is_banned(seats_[index].id)) {
        broken("banned", "an honest worker");
      }
    }
  }
  if (look || scenario_.units * scenario_.clients <= kFewUnits) {
    if (const std::string wrong = flight.inconsistency(); !wrong.empty()) {
      broken("books", wrong);
    }
    for (const auto& [place, deaths] : deaths_at_) {
      const Unit unit{place.first, place.second};
      if (dispatcher_.requests().count(unit.request) != 0 && flight.deaths(unit) > deaths) {
        broken("suspects", fmt::format("{} deaths count against {}, {} processes died with it", flight.deaths(unit),
                                       shown(unit), deaths));
      }
    }
  }
  const DispatchStatistics now = dispatcher_.statistics();
  if (now.workers_lost > closed_links_ || now.quarantined > liars_.size() || now.apart > apart_done_) {
    broken("report",
           fmt::format("{} workers lost of {} let go; {} quarantined of {} liars; {} computed apart of {}",
                       now.workers_lost, closed_links_, now.quarantined, liars_.size(), now.apart, apart_done_));
  }
  if (now.requeued < before.requeued || now.suspect < before.suspect || now.duplicates < before.duplicates ||
      (now.workers_lost == before.workers_lost && now.suspect != before.suspect)) {
    broken("report", "counts what did not happen");
  }
  if (scenario_.own_processes == false && now.suspect != 0) {
    broken("suspects", "nobody saw a process end, and yet a death was counted");
  }
  if (now.suspect != before.suspect) {  // what others hold is not suspect because a process of ours died
    for (std::size_t other = scenario_.workers; other < seats_.size(); ++other) {
      for (const Batch& batch : seats_[other].sent) {
        for (std::uint32_t i = 0; i < batch.count && dispatcher_.requests().count(batch.request) != 0; ++i) {
          const auto died = deaths_at_.find({batch.request, batch.first + i});
          const Unit unit{batch.request, batch.first + i};
          if (flight.deaths(unit) > (died == deaths_at_.end() ? 0 : died->second)) {
            broken("suspects", "a death counts against " + shown(unit) + ", which no process died with");
          }
        }
      }
    }
  }
  check_isolated();
  if (now.quarantined != before.quarantined) {
    for (const auto& [liar, lies] : lies_taken_) {
      if (lies > 0 && dispatcher_.roster().is_liar(liar)) {
        broken("revokes", fmt::format("{} lies of a worker that is found out stay", lies));
      }
    }
  }
}

// Once all is well, a unit that travels alone gets a worker before many others do.
void World::check_isolated() {
  const std::uint32_t isolated = dispatcher_.flight().isolated_waiting();
  if (!faults_over_ || isolated == 0 || isolated != isolated_before_) {
    isolated_before_ = isolated;
    sent_before_ = sent_.size();
  }
  const std::size_t many = 1000 + 100 * scenario_.seats() * (scenario_.lanes + scenario_.ahead);
  if (sent_.size() - sent_before_ > many) {
    broken("starves", fmt::format("{} units that travel alone wait while {} batches of others are sent", isolated,
                                  sent_.size() - sent_before_));
  }
}

void World::check_taken(RequestId request, const Dispatcher::Finished& finished) {
  if (finished.outcomes.size() != units_of(request)) {
    broken("outcomes", fmt::format("{} of {} units", finished.outcomes.size(), units_of(request)));
  }
  for (std::uint32_t unit = 0; unit < units_of(request); ++unit) {
    const UnitOutcome expected = truth(request, unit);
    if (finished.outcomes[unit] == expected) {
      continue;
    }
    const WorkerId liar = word_in(finished.outcomes[unit]).liar;
    const bool said = finished.outcomes[unit] == lie(request, unit, liar) && liars_.count(liar) != 0;
    if (!said) {
      broken("outcomes", fmt::format("{} has one that nobody computed", shown({request, unit})));
    }
    if (scenario_.cross_check == 1000 || dispatcher_.roster().is_liar(liar)) {
      broken("outcomes", fmt::format("{} has a lie that must have been found", shown({request, unit})));
    }
    ++lies_taken_[liar];
  }
}

void World::check_failure(const Failure& failure) {
  if (failure.error.kind == ErrorKind::revoked) {
    if (liars_.empty()) {
      broken("fails", "revokes what nobody lied about");
    }
    return;
  }
  if (failure.deadly) {
    if (!deadly_everywhere_ || deadly_ != failure.deadly) {
      broken("fails", "calls a unit deadly that is not: " + shown(*failure.deadly));
    }
    return;
  }
  if (scenario_.own_processes && dispatcher_.processes() == 0) {
    return;
  }
  // What the faults did may be noticed a little after their end.
  const bool well_for_long = faults_over_ && now_ - faults_over_at_ > 10 * kSecond;
  if (well_for_long || (scenario_.faults.empty() && scenario_.lost == 0)) {
    broken("fails", "without a reason: " + failure.error.message);
  }
}

void World::check_end() const {
  if (!faults_over_ || run_over_ || open_when_faults_ended_.empty()) {
    return;
  }
  const double units =
      static_cast<double>(scenario_.units) * scenario_.clients + static_cast<double>(scenario_.demes) * scenario_.epoch;
  const double ideal = units * static_cast<double>(scenario_.each);
  if (static_cast<double>(now_ - faults_over_at_) > kRecovery + kTolerance * ideal) {
    const InFlight& flight = dispatcher_.flight();
    std::string workers;
    for (const auto& [id, worker] : dispatcher_.roster().all()) {
      workers += fmt::format("; ready {} load {} of {}", worker.ready(), flight.load(id), flight.credit(id));
    }
    broken("ends",
           fmt::format("request {} is still open {:.0f} s after the last fault: {} units unsettled, {} waiting, "
                       "{} to be computed apart, {} workers ready{}",
                       static_cast<std::uint64_t>(*open_when_faults_ended_.begin()),
                       static_cast<double>(now_ - faults_over_at_) / kSecond, flight.unsettled(), flight.waiting(),
                       flight.waiting_apart(), dispatcher_.roster().ready(), workers));
  }
}

}  // namespace coppice::simulation
