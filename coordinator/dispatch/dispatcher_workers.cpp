// Who is there: workers met and let go, their names, and the processes of the coordinator's own.
#include <algorithm>
#include <fmt/format.h>
#include <utility>

#include "coordinator/dispatch/dispatcher.hpp"
#include "coordinator/dispatch/mutation.hpp"

namespace coppice {
namespace {

using namespace std::chrono_literals;

constexpr auto kNoticeInterval = 10s;  // "waiting for a worker" is repeated this often
constexpr auto kLongestHangLimit = 3600s;
constexpr int kHangFactor = 4;   // times the measured cost of a unit, if that is longer than the limit
constexpr auto kLongLife = 30s;  // a process that lived so long may be started again as often as ever

}  // namespace

bool Dispatcher::listens_to(WorkerId worker, const std::optional<Origin>& origin) const {
  const auto speaker = roster_.speaker(worker, origin);
  return (speaker == Roster::Speaker::own || speaker == Roster::Speaker::first) && !roster_.is_banned(worker);
}

// Whether what came in this name came from the worker of that name, or from nobody that is known.
bool Dispatcher::own(WorkerId worker, const std::optional<Origin>& origin, const char* what) {
  switch (roster_.speaker(worker, origin)) {
    case Roster::Speaker::own:
    case Roster::Speaker::first:
      return true;
    case Roster::Speaker::other:
      if (COPPICE_MUTATED(anybody_keeps_alive)) {
        return true;
      }
      reject(fmt::format("{} in its name, from somebody else", what), worker);
      return false;
    case Roster::Speaker::unknown:
      if (COPPICE_MUTATED(anybody_may_say_farewell)) {
        return true;
      }
      // Nothing is lost: what a worker that is gone had goes to others.
      ++statistics_.rejected;
      return false;
  }
  return false;
}

void Dispatcher::on(HelloHeard& hello) {
  if (!own(hello.worker, hello.origin, "a Hello") || refuse(hello)) {
    return;
  }
  if (hello.leaving) {
    if (const KnownWorker* const worker = roster_.find(hello.worker); worker != nullptr) {
      say(Say::Level::debug, fmt::format("worker {} left", worker->name));
      // A batch may have crossed its farewell: it goes to others at once.
      const auto loss = flight_.lose_worker(hello.worker, LossCause::left);
      statistics_.requeued += loss.batches;
      statistics_.retried += loss.units;
      roster_.let_go(hello.worker);
      actions_.actions.emplace_back(CloseLink{hello.worker});
    }
    return;
  }
  KnownWorker* worker = roster_.find(hello.worker);
  if (worker == nullptr) {
    if (roster_.is_banned(hello.worker) || roster_.full()) {
      return;
    }
    worker = &roster_.meet(hello);
    flight_.add_worker(hello.worker, worker->lanes);
    say(Say::Level::debug, fmt::format("worker {} is here", worker->name));
    actions_.actions.emplace_back(OpenLink{hello.worker});
  }
  roster_.hear(*worker, hello);
  // A worker that was out of reach has let go of the run, and is not told again by itself.
  stranger_ = stranger_ || !hello.serves;
}

bool Dispatcher::refuse(const HelloHeard& hello) {
  if (hello.protocol == settings_.protocol && hello.golden == settings_.golden) {
    return false;
  }
  if (roster_.first_refusal(hello.worker)) {
    ++statistics_.refused;
    say(Say::Level::warn,
        hello.protocol != settings_.protocol
            ? fmt::format(
                  "refused the worker {} (version {}): it speaks protocol {}, this coordinator (version {}) {}: "
                  "install the same version of Coppice on both",
                  hello.name, hello.version, hello.protocol, settings_.version, settings_.protocol)
            : fmt::format(
                  "refused the worker {} (version {}): it computes otherwise than this coordinator (version {}): the "
                  "golden job gives {:016x} there and {:016x} here; install the same build of Coppice on both",
                  hello.name, hello.version, settings_.version, hello.golden, settings_.golden));
  }
  return true;
}

void Dispatcher::on(BlocksAsked& asked) {
  if (own(asked.worker, asked.origin, "a request") && roster_.find(asked.worker) != nullptr) {
    roster_.find(asked.worker)->heard = roster_.listened();
    actions_.actions.emplace_back(SendBlocks{asked.worker, asked.first, asked.count});
  }  // else its Hello is still on the way: it asks again
}

void Dispatcher::on(NonsenseHeard& heard) { reject(heard.what, heard.worker); }

void Dispatcher::on(LinkChanged& changed) {
  if (KnownWorker* const worker = roster_.find(changed.worker); worker != nullptr) {
    worker->linked = changed.settled;
  }
}

void Dispatcher::on(SendFailed& failed) {
  const KnownWorker* const worker = roster_.find(failed.worker);
  say(Say::Level::warn, fmt::format("worker {}: {}", worker != nullptr ? worker->name : "", failed.why));
  if (flight_.give_back(failed.batch, failed.worker)) {
    ++statistics_.requeued;
  }
}

void Dispatcher::on(ProcessStarted& started) {
  Place& place = places_.at(started.place);
  place.running = true;
  place.started = now_;
}

void Dispatcher::on(ProcessEnded& ended) {
  Place& place = places_.at(ended.place);
  place.restarts = now_ - place.started > kLongLife ? 0 : place.restarts;
  std::string next;
  if (place.restarts >= kMaxRestarts || ended.pid == 0) {
    place.running = false;
    next = ended.pid == 0 ? "" : fmt::format("; not started again after {} times in a row", kMaxRestarts);
  } else {
    ++place.restarts;
    place.started = now_;
    actions_.actions.emplace_back(StartProcess{ended.place});
    next = "; another is started in its place";
  }
  say(Say::Level::warn, ended.how + next);
  // A process of our own is known to be dead before its silence tells.
  const auto& workers = roster_.all();
  const auto worker = std::find_if(workers.begin(), workers.end(), [&](const auto& entry) {
    return (entry.second.here || COPPICE_MUTATED(foreign_processes_are_ours)) && ended.pid != 0 &&
           entry.second.pid == ended.pid;
  });
  if (worker != workers.end()) {
    lose(worker->first, ended.in_order ? "ended" : "died", ended.in_order ? LossCause::left : LossCause::died);
  }
}

std::size_t Dispatcher::processes() const {
  return static_cast<std::size_t>(
      std::count_if(places_.begin(), places_.end(), [](const Place& place) { return place.running; }));
}

// A sample that did not decode or belongs to nobody: counted, logged once for each source.
void Dispatcher::reject(const std::string& what, WorkerId source) {
  ++statistics_.rejected;
  ++record_of(source).rejected;
  if (roster_.first_nonsense(source)) {
    say(Say::Level::warn, fmt::format("dropped a sample of worker {:016x}: {} (further ones are only counted)",
                                      static_cast<std::uint64_t>(source), what));
  }
}

SourceRecord& Dispatcher::record_of(WorkerId source) {
  const KnownWorker* const worker = roster_.find(source);
  std::string name =
      worker != nullptr ? worker->name : fmt::format("worker {:016x}", static_cast<std::uint64_t>(source));
  return sources_[sources_.size() < kMostSources || sources_.count(name) != 0 ? std::move(name) : "others"];
}

// A worker that answers nonsense would do so again: its Hellos are not heard any more.
void Dispatcher::ban(WorkerId worker, const std::string& why) {
  roster_.ban(worker);
  lose(worker, why, LossCause::left);
}

void Dispatcher::lose(WorkerId id, const std::string& why, LossCause cause) {
  const KnownWorker* const worker = roster_.find(id);
  if (worker == nullptr) {
    return;
  }
  const auto loss = flight_.lose_worker(id, cause);
  ++statistics_.workers_lost;
  statistics_.requeued += loss.batches;
  statistics_.retried += loss.units;
  statistics_.suspect += loss.suspect;
  say(Say::Level::warn, fmt::format("worker {} {}; batches given to others: {}", worker->name, why, loss.batches));
  roster_.let_go(id);
  actions_.actions.emplace_back(CloseLink{id});
}

void Dispatcher::lose_silent() {
  for (const WorkerId id : roster_.silent()) {
    lose(id, "is out of reach", LossCause::unreachable);
  }
}

std::chrono::nanoseconds Dispatcher::longest_each(const KnownWorker& worker) const {
  std::chrono::nanoseconds longest{0};
  for (const auto& [id, request] : requests_) {
    longest = std::max(longest, worker.pace.each(request.terms.work));
  }
  return longest;
}

// A worker that says Hello but stands still hangs, or never got what was sent. Its work goes to others; its next Hello
// makes it a worker like any other again. The limit doubles, so that units that take very long are not sent again and
// again.
void Dispatcher::lose_hanging() {
  std::vector<WorkerId> hanging;
  for (const auto& [id, worker] : roster_.all()) {
    const auto usual = longest_each(worker) * kHangFactor;
    if (flight_.load(id) > 0 &&
        roster_.listened() - worker.progressed > std::max<std::chrono::nanoseconds>(hang_limit_, usual)) {
      hanging.push_back(id);
    }
  }
  for (const WorkerId id : hanging) {
    lose(id, "makes no progress", LossCause::left);
  }
  if (!hanging.empty()) {
    hang_limit_ = std::min<std::chrono::seconds>(hang_limit_ * 2, kLongestHangLimit);
  }
}

void Dispatcher::tend() {
  if (std::exchange(stranger_, false)) {
    actions_.actions.emplace_back(Announce{});
  }
  lose_silent();
  lose_hanging();
  const auto overdue = flight_.offer_overdue_again(now_);
  statistics_.copies += overdue.batches;
  statistics_.retried += overdue.units;
  if (apart_ > 0) {  // which may take as long as it takes
    last_settled_ = roster_.listened();
    without_worker_since_.reset();
    return;
  }
  if (roster_.ready() > 0 && without_worker_since_) {  // while nobody was there, nobody could answer
    last_settled_ = std::min(roster_.listened(), last_settled_ + (roster_.listened() - *without_worker_since_));
    without_worker_since_.reset();
  }
  if (!requests_.empty() && roster_.listened() - last_settled_ > settings_.wait_limit && roster_.ready() > 0) {
    fail({ErrorKind::no_worker,
          fmt::format("no batch was answered for {} s; what was evaluated is kept",
                      std::chrono::duration_cast<std::chrono::seconds>(settings_.wait_limit).count())});
    return;
  }
  await_workers();
}

// Logs that nobody is there, now and then; fails when nobody came for too long, or nobody can.
void Dispatcher::await_workers() {
  if (roster_.ready() > 0) {
    return;
  }
  if (!places_.empty() && processes() == 0) {
    fail({ErrorKind::no_worker, "all worker processes ended; what was evaluated is kept"});
    return;
  }
  const auto listened = roster_.listened();
  if (!without_worker_since_) {
    without_worker_since_ = listened;
    // Workers of our own need a moment: no word about it unless they take long.
    next_notice_ = places_.empty() ? listened : listened + kNoticeInterval;
  }
  if (listened - *without_worker_since_ > settings_.wait_limit) {
    fail({ErrorKind::no_worker,
          fmt::format("no worker within {} s; what was evaluated is kept",
                      std::chrono::duration_cast<std::chrono::seconds>(settings_.wait_limit).count())});
    return;
  }
  if (listened >= next_notice_) {
    next_notice_ = listened + kNoticeInterval;
    say(Say::Level::warn,
        fmt::format(
            "no worker is there; waiting. Start one: {}{}{}", settings_.invitation,
            statistics_.refused > 0 ? fmt::format(". {} refused: see above", statistics_.refused) : std::string(),
            settings_.absence.empty() ? std::string() : ". " + settings_.absence));
  }
}

}  // namespace coppice
