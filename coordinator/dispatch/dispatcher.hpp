// The coordinator's side of dispatch as a deterministic machine: step(events, now) -> actions. It keeps the tables
// (InFlight), the workers (Roster), the requests and their outcomes, and the record of who can be believed, and decides
// everything: who gets what, who is gone, what is offered twice, what is computed again, when a run must stop. It has
// no transport, no clock, no thread, no randomness but its seed, and calls nobody: the same events at the same times
// give the same actions. README.md draws the picture.
//
// What it promises, whatever the events: a unit has one outcome, the one that its pure function gives, as far as
// workers are honest or found out; no unit is given up; a request whose units can be computed at all is done in the
// end, while one honest worker is there for long enough; and what happened is counted.
//
// Belongs to one thread.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "coordinator/dispatch/action.hpp"
#include "coordinator/dispatch/cross_check.hpp"
#include "coordinator/dispatch/evaluator.hpp"
#include "coordinator/dispatch/event.hpp"
#include "coordinator/dispatch/in_flight.hpp"
#include "coordinator/dispatch/requests.hpp"
#include "coordinator/dispatch/roster.hpp"
#include "coordinator/dispatch/work.hpp"

namespace coppice {

// What came from one source, and was not believed.
struct SourceRecord {
  std::uint64_t rejected = 0;     // samples
  std::uint64_t disagreeing = 0;  // answers that differ from the truth
};

struct DispatchSettings {
  InFlightLimits limits{};
  std::chrono::milliseconds wait_limit{600'000};  // without any worker, or any answer, for this long, requests fail
  double cross_check = 0.0;                       // share of all units, see CrossCheck
  std::uint64_t seed = 0;                         // of the sample
  std::size_t places = 0;                         // for worker processes of this coordinator's own; 0: others come
  std::uint32_t protocol = 0;                     // workers that speak another are refused
  std::uint64_t golden = 0;                       // and those whose build computes otherwise (HelloHeard::golden)
  std::string version{};                          // of this program, for messages
  std::string invitation{};                       // how to start a worker, for messages
  std::string absence{};                          // why one that runs may not be here, likewise
};

class Dispatcher {
 public:
  using Time = InFlight::Time;

  static constexpr int kMaxRestarts = 6;  // of the process in a place, in a row

  explicit Dispatcher(const DispatchSettings& settings);

  // The requester's side; what follows from it comes out of the next step().
  RequestId open(const RequestTerms& terms, Time now);
  // So many more units. REQUIRES: open, not sealed.
  void add(RequestId request, std::uint32_t units);
  // No more units come.
  void seal(RequestId request);
  // Sealed, and every outcome is there.
  bool done(RequestId request) const;
  struct Finished {
    std::vector<UnitOutcome> outcomes;  // [units]
    std::uint64_t repeated = 0;         // units that workers found to be the same as others
  };
  // Ends a request. REQUIRES: done(request).
  Finished take(RequestId request);
  // The requester gets on without workers just now: that none is there is no reason to fail.
  void needs_nobody() { without_worker_since_.reset(); }
  // Ends all requests; after a failure, or when nobody waits for them any more.
  void abandon();

  // Takes in what happened, and says what is to be done. Outcomes are moved out of the events. REQUIRES: `now` never
  // goes back.
  Actions step(std::span<DispatchEvent> events, Time now);

  // To take an answer apart before it becomes an event: the batch as it went out to that worker.
  std::optional<InFlight::Found> find(BatchId batch, WorkerId worker) const { return flight_.find(batch, worker); }
  // Whether what comes from this origin in that name is listened to at all.
  bool listens_to(WorkerId worker, const std::optional<Origin>& origin) const;

  const Roster& roster() const { return roster_; }
  const InFlight& flight() const { return flight_; }
  const OpenRequests& requests() const { return requests_; }
  // Whether some worker takes at least so long for a unit.
  bool somebody_takes(const WorkClass& work, std::chrono::nanoseconds each) const;
  // Computing threads of the workers that are ready.
  std::size_t ready_lanes() const;
  DispatchStatistics statistics() const;
  // By "host, pid N" of a worker that was met, else by the name that it claimed; of many the first kMostSources.
  static constexpr std::size_t kMostSources = 64;
  const std::map<std::string, SourceRecord>& sources() const { return sources_; }
  // Processes of its own that run, or are about to.
  std::size_t processes() const;

 private:
  using LossCause = InFlight::LossCause;

  // An answer that waits for its sample.
  struct Examination {
    AnswerHeard answer;
    RequestId request{};
    std::vector<std::uint32_t> sample;  // units of its batch, counted from its first
    Time heard;
  };
  struct Redo {
    RequestId request{};
    std::vector<std::uint32_t> units;
  };
  struct AtHome {
    BatchId batch{};
    bool apart = false;
  };
  using Purpose = std::variant<Examination, Redo, AtHome>;

  struct Place {
    bool running = true;
    int restarts = 0;  // in a row
    Time started{};
  };

  void on(HelloHeard& event);
  void on(AnswerHeard& event);
  void on(BlocksAsked& event);
  void on(NonsenseHeard& event);
  void on(LinkChanged& event);
  void on(SendFailed& event);
  void on(ProcessStarted& event);
  void on(ProcessEnded& event);
  void on(Computed& event);

  // dispatcher_answers.cpp
  void on_computed_answer(AnswerHeard& answer);
  std::vector<std::uint32_t> differing(const AnswerHeard& answer, const Batch& batch);
  void examine(AnswerHeard& answer, const Batch& batch, std::vector<std::uint32_t> sample);
  void settle(AnswerHeard& answer, const Batch& batch, const std::vector<std::uint32_t>& checked, Time heard);
  void learn_pace(const AnswerHeard& answer, const InFlight::Found& out, Time heard);
  void finish(Examination& examination, Computed& computed);
  void finish(Redo& redo, Computed& computed);
  void finish(AtHome& home, Computed& computed);
  void quarantine(WorkerId from);

  // dispatcher_workers.cpp
  bool own(WorkerId worker, const std::optional<Origin>& origin, const char* what);
  bool refuse(const HelloHeard& hello);
  void reject(const std::string& what, WorkerId source);
  SourceRecord& record_of(WorkerId source);
  void ban(WorkerId worker, const std::string& why);
  void lose(WorkerId worker, const std::string& why, LossCause cause);
  void lose_silent();
  void lose_hanging();
  void tend();
  void await_workers();

  void hand_out();
  void compute_apart();
  ComputeId compute(RequestId request, std::vector<std::uint32_t> units, bool apart, Purpose purpose);
  void close(OpenRequests::iterator request);
  void say(Say::Level level, std::string text) { actions_.actions.emplace_back(Say{level, std::move(text)}); }
  void fail(Error error, std::optional<Unit> deadly = {});
  std::chrono::nanoseconds longest_each(const KnownWorker& worker) const;

  DispatchSettings settings_;
  InFlight flight_;
  Roster roster_;
  OpenRequests requests_;
  CrossCheck cross_check_;
  std::map<ComputeId, Purpose> computing_;
  std::vector<Place> places_;
  DispatchStatistics statistics_;
  std::map<std::string, SourceRecord> sources_;
  Actions actions_;  // of the step under way
  Time now_{};

  std::uint64_t next_request_ = 1;
  std::uint64_t next_compute_ = 1;
  std::size_t begun_ = 0;  // requests since the paces were last doubted
  std::size_t apart_ = 0;  // units that are being computed apart
  Time next_tending_{};
  std::chrono::nanoseconds last_settled_{0};  // listened time; or when there was nothing to settle
  std::chrono::seconds hang_limit_;
  std::optional<std::chrono::nanoseconds> without_worker_since_;  // listened time
  std::chrono::nanoseconds next_notice_{0};
  bool stranger_ = false;  // somebody was heard who does not know of the run
};

}  // namespace coppice
