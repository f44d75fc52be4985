// What workers answer, and whether they are believed.
#include <algorithm>
#include <fmt/format.h>
#include <set>
#include <utility>

#include "common/check.hpp"
#include "coordinator/dispatch/dispatcher.hpp"
#include "coordinator/dispatch/mutation.hpp"

namespace coppice {
namespace {

using namespace std::chrono_literals;

constexpr auto kRestAfterShortage = 1s;    // a worker whose memory did not suffice gets nothing meanwhile
constexpr std::size_t kMostRedone = 1024;  // units in one computation: between two the coordinator listens

}  // namespace

void Dispatcher::on(AnswerHeard& answer) {
  if (!own(answer.worker, answer.origin, "an answer")) {
    return;
  }
  KnownWorker* const worker = roster_.find(answer.worker);
  if (worker != nullptr) {
    worker->heard = roster_.listened();
  }
  if (roster_.is_banned(answer.worker)) {
    ++statistics_.rejected;
    return;
  }
  switch (answer.kind) {
    case AnswerHeard::Kind::computed:
      on_computed_answer(answer);
      return;
    case AnswerHeard::Kind::refused:
      reject("it refused a batch: " + answer.text, answer.worker);
      ban(answer.worker, "refused a batch");
      return;
    case AnswerHeard::Kind::damaged:
      reject(answer.text, answer.worker);
      ban(answer.worker, "sent a damaged answer");
      return;
    case AnswerHeard::Kind::chain_unknown:
      if (worker != nullptr) {
        worker->holds_chain = false;  // until its next Hello says otherwise
      }
      break;
    case AnswerHeard::Kind::no_memory:
      say(Say::Level::warn, fmt::format("worker {} lacks the memory for a batch: it goes to others, in smaller pieces",
                                        worker != nullptr ? worker->name : ""));
      if (worker != nullptr && !COPPICE_MUTATED(short_memory_asked_again)) {
        worker->rests_until = roster_.listened() + kRestAfterShortage;
      }
      break;
    case AnswerHeard::Kind::given_back:
      break;
  }
  const auto reason =
      answer.kind == AnswerHeard::Kind::no_memory ? InFlight::Reason::lacks_memory : InFlight::Reason::leaves;
  if (const auto out = flight_.find(answer.batch, answer.worker);
      out && flight_.give_back(answer.batch, answer.worker, reason)) {
    ++statistics_.requeued;
    statistics_.retried += out->batch.count;
  }
}

void Dispatcher::on_computed_answer(AnswerHeard& answer) {
  statistics_.received_bytes += answer.bytes;
  statistics_.busy_ns += static_cast<std::uint64_t>(std::max<std::int64_t>(answer.elapsed.count(), 0));
  const auto out = flight_.find(answer.batch, answer.worker);
  if (!out || !out->current) {
    if (out) {
      learn_pace(answer, *out, now_);
    }
    flight_.settle(answer.batch, answer.worker, now_);  // of a request that is closed: frees the worker's credit
    ++statistics_.duplicates;
    return;
  }
  COPPICE_CHECK(answer.outcomes.size() == out->batch.count);
  // What others have answered is a sample that costs nothing, until it differs.
  std::vector<std::uint32_t> sample = differing(answer, out->batch);
  const std::vector<std::uint32_t> drawn = cross_check_.sample(answer.worker, out->batch.count);
  sample.insert(sample.end(), drawn.begin(), drawn.end());
  std::sort(sample.begin(), sample.end());
  sample.erase(std::unique(sample.begin(), sample.end()), sample.end());
  if (sample.empty()) {
    settle(answer, out->batch, {}, now_);
  } else {
    examine(answer, out->batch, std::move(sample));
  }
}

std::vector<std::uint32_t> Dispatcher::differing(const AnswerHeard& answer, const Batch& batch) {
  std::vector<std::uint32_t> places;
  const OpenRequest& request = requests_.at(batch.request);
  for (std::uint32_t i = 0; i < batch.count; ++i) {
    if (flight_.is_settled({batch.request, batch.first + i})) {
      ++statistics_.compared;
      if (request.outcomes[batch.first + i] != answer.outcomes[i]) {
        places.push_back(i);
      }
    }
  }
  return places;
}

void Dispatcher::examine(AnswerHeard& answer, const Batch& batch, std::vector<std::uint32_t> sample) {
  std::vector<std::uint32_t> units = sample;
  for (std::uint32_t& unit : units) {
    unit += batch.first;
  }
  statistics_.cross_checked += units.size();
  ++requests_.at(batch.request).undecided;
  flight_.answered(answer.batch, answer.worker);
  compute(batch.request, std::move(units), false,
          Examination{std::move(answer), batch.request, std::move(sample), now_});
}

void Dispatcher::settle(AnswerHeard& answer, const Batch& batch, const std::vector<std::uint32_t>& checked,
                        Time heard) {
  const auto out = flight_.find(answer.batch, answer.worker);
  if (out) {
    learn_pace(answer, *out, heard);
  }
  const auto settlement = flight_.settle(answer.batch, answer.worker, now_);
  if (settlement.fresh.empty()) {
    ++statistics_.duplicates;
    return;
  }
  last_settled_ = roster_.listened();
  OpenRequest& request = requests_.at(batch.request);
  request.repeated += std::min(answer.repeated, batch.count);
  std::uint32_t unchecked = 0;
  for (const std::uint32_t unit : settlement.fresh) {
    const bool looked_at = std::binary_search(checked.begin(), checked.end(), unit - batch.first);
    request.outcomes[unit] = std::move(answer.outcomes[unit - batch.first]);
    request.believed[unit] = looked_at ? kHome : answer.worker;
    unchecked += looked_at ? 0 : 1;
  }
  cross_check_.took_unchecked(answer.worker, unchecked);
}

// Counts for batches that a copy has overtaken, too: their worker is the one that must become known as slow.
void Dispatcher::learn_pace(const AnswerHeard& answer, const InFlight::Found& out, Time heard) {
  if (KnownWorker* const worker = roster_.find(answer.worker); worker != nullptr) {
    // No longer than it was away, whatever it says.
    worker->pace.add(std::min<std::chrono::nanoseconds>(answer.elapsed, heard - out.sent), out.batch.count, out.work);
  }
}

void Dispatcher::on(Computed& computed) {
  const auto found = computing_.find(computed.id);
  if (found == computing_.end()) {
    return;  // for a request that was abandoned
  }
  Purpose purpose = std::move(found->second);
  computing_.erase(found);
  std::visit([&](auto& why) { finish(why, computed); }, purpose);
}

void Dispatcher::finish(Examination& examination, Computed& computed) {
  AnswerHeard& answer = examination.answer;
  const auto request = requests_.find(examination.request);
  if (request == requests_.end()) {
    flight_.settle(answer.batch, answer.worker, now_);
    return;
  }
  --request->second.undecided;
  const auto out = flight_.find(answer.batch, answer.worker);
  if (!out) {
    return;
  }
  const Batch batch = out->batch;
  COPPICE_CHECK(computed.outcomes.size() == examination.sample.size());
  std::set<WorkerId> liars;
  bool honest = true;
  for (std::size_t i = 0; i < examination.sample.size(); ++i) {
    const std::uint32_t unit = batch.first + examination.sample[i];
    const UnitOutcome& truth = computed.outcomes[i];
    honest = honest && answer.outcomes[examination.sample[i]] == truth;
    const WorkerId believed = request->second.believed[unit];
    if (believed != kHome && flight_.is_settled({batch.request, unit}) && request->second.outcomes[unit] != truth) {
      liars.insert(believed);
    }
  }
  if (!honest) {
    liars.insert(answer.worker);
  }
  for (const WorkerId liar : liars) {
    ++record_of(liar).disagreeing;
  }
  for (const WorkerId liar : liars) {
    quarantine(liar);
  }
  if (!roster_.is_banned(answer.worker)) {
    settle(answer, batch, examination.sample, examination.heard);
  }
}

void Dispatcher::finish(Redo& redo, Computed& computed) {
  const auto request = requests_.find(redo.request);
  if (request == requests_.end()) {
    return;
  }
  COPPICE_CHECK(computed.outcomes.size() == redo.units.size());
  --request->second.undecided;
  for (std::size_t i = 0; i < redo.units.size(); ++i) {
    request->second.outcomes[redo.units[i]] = std::move(computed.outcomes[i]);
  }
  last_settled_ = roster_.listened();
}

void Dispatcher::finish(AtHome& home, Computed& computed) {
  apart_ -= home.apart ? 1 : 0;
  const auto out = flight_.find(home.batch, kHome);
  if (!out) {
    return;
  }
  const Batch batch = out->batch;
  if (COPPICE_MUTATED(deadly_units_go_on) && !computed.died.empty()) {
    computed.outcomes.assign(batch.count, Tally{});
  } else if (!computed.died.empty()) {
    const Unit unit{batch.request, batch.first};
    fail({ErrorKind::failed,
          fmt::format("{} worker process{} ended while evaluating an individual, and so did a process of its own ({})",
                      flight_.deaths(unit), flight_.deaths(unit) == 1 ? "" : "es", computed.died)},
         unit);
    return;
  }
  const auto settlement = flight_.settle(home.batch, kHome, now_);
  OpenRequest& request = requests_.at(batch.request);
  for (const std::uint32_t unit : settlement.fresh) {
    request.outcomes[unit] = std::move(computed.outcomes[unit - batch.first]);
    request.believed[unit] = kHome;
  }
  (home.apart ? statistics_.apart : statistics_.at_home) += batch.count;
  last_settled_ = roster_.listened();
}

// A worker answered wrongly: nothing that it said counts any more, unless it was checked. In the requests that are open
// it is computed again here, what was handed out earlier is revoked.
void Dispatcher::quarantine(WorkerId from) {
  std::size_t again = 0;
  for (auto& [id, request] : requests_) {
    std::vector<std::uint32_t> places = request.believed_of(from);
    again += places.size();
    if (COPPICE_MUTATED(liars_words_stay)) {
      continue;
    }
    for (const std::uint32_t place : places) {
      request.believed[place] = kHome;
    }
    for (std::size_t begin = 0; begin < places.size(); begin += kMostRedone) {
      const auto first = places.begin() + static_cast<std::ptrdiff_t>(begin);
      std::vector<std::uint32_t> some(
          first, first + static_cast<std::ptrdiff_t>(std::min(kMostRedone, places.size() - begin)));
      ++request.undecided;
      compute(id, some, false, Redo{id, some});
    }
  }
  const std::uint64_t earlier =
      cross_check_.unchecked(from) - std::min<std::uint64_t>(again, cross_check_.unchecked(from));
  cross_check_.forget_unchecked(from, again);
  const KnownWorker* const worker = roster_.find(from);
  const std::string said =
      fmt::format("worker {} answered wrongly and is quarantined",
                  worker != nullptr ? worker->name : fmt::format("{:016x}", static_cast<std::uint64_t>(from)));
  if (roster_.first_lie(from)) {
    ++statistics_.quarantined;
    say(Say::Level::error,
        fmt::format("{}: {} of its individuals in this generation were evaluated again; {} in earlier ones had counted "
                    "as it said",
                    said, again, earlier));
  }
  if (earlier > 0) {
    cross_check_.begin_again();
    fail({ErrorKind::revoked, fmt::format("{}, after {} of its individuals had counted as it said", said, earlier)});
  }
  ban(from, "is quarantined");
}

}  // namespace coppice
