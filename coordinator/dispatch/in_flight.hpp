// Who has which units: the bookkeeping of requests on their way through the workers, one or several at a time, without
// DDS, threads or clocks of its own (time is passed in), so that every fault can be tested as a sequence of calls.
//
// The life of a unit: waiting -> out at a worker, or at home, in a batch -> settled by the first answer that names it.
// A lost worker's units wait again, at the front; when nothing waits, a batch that is overdue, or that an idle worker
// would have done long before its own, may be offered to a second worker as a copy. Because an outcome is a pure
// function of its unit, it does not matter which answer comes first.
//
// A unit is never given up. A worker that is known to have died counts against what it was at work on: after
// isolate_after deaths a unit travels alone, after apart_after it waits to be computed apart (by the coordinator, in a
// process of its own). A worker that went out of reach proves nothing against its units; yet after lost_before_apart of
// them a unit is computed apart as well, so that what kills workers on hosts of which we hear no more ends somewhere.
// What a worker lacked the memory for travels alone next, and after short_before_apart such answers is computed apart.
//
// Requests are served in the order in which they were opened. A batch holds units of one request.
//
// Invariant: every unit of a request is settled, or waiting, or waits to be computed apart, or is in a batch that is
// out.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "coordinator/dispatch/work.hpp"

namespace coppice {

struct InFlightLimits {
  std::size_t ahead = 1;                 // batches out at a worker beyond those at work, to hide the way there
  std::uint32_t isolate_after = 2;       // deaths of workers at work on a unit after which it travels alone
  std::uint32_t apart_after = 3;         // such deaths after which it is computed apart
  std::uint32_t lost_before_apart = 8;   // workers out of reach with a unit after which it is computed apart
  std::uint32_t short_before_apart = 4;  // workers whose memory did not suffice, after which it is computed apart
  std::uint32_t copies = 2;              // of one batch; a copy is not copied
};

class InFlight {
 public:
  using Time = std::chrono::steady_clock::time_point;
  using Duration = std::chrono::steady_clock::duration;

  explicit InFlight(const InFlightLimits& limits) : limits_(limits) {}

  // A request without units. `most_per_batch`: units in one batch; `work`: the class of all its units. REQUIRES: never
  // opened before; most_per_batch >= 1.
  void open(RequestId request, std::uint32_t most_per_batch = ~std::uint32_t{0}, const WorkClass& work = {});
  // So many more units of it, after those it has. REQUIRES: open.
  void add(RequestId request, std::uint32_t units);
  // Forgets a request, settled or not. What is still out of it stays charged to its worker until answered.
  void close(RequestId request);

  // A worker with so many computing threads. One that was lost and is back was only out of reach: what it held is
  // cleared. REQUIRES: lanes >= 1; not kHome.
  void add_worker(WorkerId worker, std::size_t lanes = 1);
  bool has_worker(WorkerId worker) const { return workers_.count(worker) != 0; }
  std::size_t workers() const { return workers_.size(); }
  // Batches out at a worker, copies and leftovers of closed requests included; and the units in them.
  std::size_t load(WorkerId worker) const;
  std::uint32_t backlog(WorkerId worker) const;
  // Batches that may be out at it.
  std::size_t credit(WorkerId worker) const;
  // How long the worker is busy with them, if a unit takes `each`; 0 when it should have answered already.
  Duration remaining(WorkerId worker, Time now, Duration each) const;

  // What may be expected of a worker.
  struct Terms {
    Duration patience{0};  // after it a batch is overdue
    Duration each{0};      // a unit takes it; 0: not known
  };
  // Whether offer() could hand this worker anything.
  bool can_take(WorkerId worker) const;
  // Takes at most `most` waiting units for the worker. None when nothing waits that it may take, or its credit is used
  // up. REQUIRES: has_worker(worker), most >= 1.
  std::optional<Batch> offer(WorkerId worker, std::uint32_t most, Time now, const Terms& terms);
  // Nothing waits and a lane is idle: a copy of the batch out at somebody else that is overdue longest, or else of
  // the one that is expected last, if the idle lane would have it in less than half that time. What a worker of unknown
  // pace holds is overdue when the idle one would have done it several times.
  // REQUIRES: has_worker(worker).
  std::optional<Batch> offer_copy(WorkerId worker, Time now, const Terms& terms);
  // A unit that travels alone needs a worker that holds nothing. While others would fill all of them up again and
  // again, the one of these that is free first is kept for it. REQUIRES: all are in the in-flight table.
  struct Candidate {
    WorkerId worker{};
    Duration remaining{0};
  };
  bool isolated_waits() const { return isolated_waiting_ > 0; }
  std::uint32_t isolated_waiting() const { return isolated_waiting_; }
  void keep_one_free(const std::vector<Candidate>& workers);
  // At most `most` waiting units of that request for the coordinator itself; isolated ones are not among them.
  std::optional<Batch> offer_home(RequestId request, std::uint32_t most, Time now);
  // The next unit that waits to be computed apart, as a batch at home.
  std::optional<Batch> offer_apart(Time now);
  std::size_t waiting_apart() const { return apart_.size(); }
  // While units wait, nobody is idle and no copy is made: what is overdue by its patience once more, and by kGrace at
  // least, waits again then, at the front, once for each batch. Nothing starves behind requests that follow.
  static constexpr std::chrono::seconds kGrace{1};
  struct Overdue {
    std::size_t batches = 0;
    std::uint32_t units = 0;
  };
  Overdue offer_overdue_again(Time now);
  // Workers with a batch that is overdue.
  std::set<WorkerId> late(Time now) const;
  // When the next batch becomes overdue, if any is out.
  std::optional<Time> next_due() const;

  enum class Settled : std::uint8_t { first, duplicate, foreign };
  struct Settlement {
    Settled kind = Settled::foreign;
    Batch batch;                       // unless foreign
    std::vector<std::uint32_t> fresh;  // units that this answer settled
  };
  // An answer. Late answers of lost workers settle too; foreign: no such batch is out at that worker.
  Settlement settle(BatchId batch, WorkerId worker, Time now);
  // The batch as it went out to that worker, to check an answer against before it settles anything. `current`: its
  // request is open, else its answer settles nothing.
  struct Found {
    Batch batch;
    bool current = false;
    Time sent;
    WorkClass work;
  };
  std::optional<Found> find(BatchId batch, WorkerId worker) const;
  // The worker has answered it, and the answer is being looked at: whatever becomes of the worker now, it does not
  // speak against these units.
  void answered(BatchId batch, WorkerId worker);
  // REQUIRES: its request is open.
  bool is_settled(const Unit& unit) const { return requests_.at(unit.request).settled[unit.index]; }
  // The worker returned the batch without an answer; its units wait again, at the front. False: foreign.
  enum class Reason : std::uint8_t { leaves, lacks_memory };
  bool give_back(BatchId batch, WorkerId worker, Reason reason = Reason::leaves);

  enum class LossCause : std::uint8_t {
    left,         // in order, or by our own doing
    unreachable,  // nobody knows what became of it
    died,         // its process is known to have ended
  };
  struct Loss {
    std::size_t batches = 0;
    std::uint32_t units = 0;    // that wait again
    std::uint32_t suspect = 0;  // of them, at work when their worker died
    std::uint32_t apart = 0;    // of them, to be computed apart now
  };
  // The worker's units wait again, at the front. Answers that still come from it count.
  Loss lose_worker(WorkerId worker, LossCause cause);

  // All open requests are settled; or this one.
  bool done() const { return unsettled_ == 0; }
  bool done(RequestId request) const { return requests_.at(request).unsettled == 0; }
  std::uint32_t unsettled() const { return unsettled_; }
  std::uint32_t waiting() const { return waiting_; }
  // Whose units go out next.
  std::optional<RequestId> front() const;
  // Deaths counted against a unit. REQUIRES: its request is open.
  std::uint32_t deaths(const Unit& unit) const;
  // How the table contradicts itself or loses a unit, in words; empty: not at all. For tests: it reads all of it.
  std::string inconsistency() const;

 private:
  struct Suspicion {
    std::uint32_t deaths = 0;
    std::uint32_t losses = 0;
    std::uint32_t shortages = 0;
  };
  struct Request {
    std::vector<bool> settled;
    std::map<std::uint32_t, Suspicion> suspicions;  // of units with any
    std::uint32_t unsettled = 0;
    std::uint32_t most_per_batch = 1;
    WorkClass work;
  };
  struct Range {
    RequestId request{};
    std::uint32_t first = 0;
    std::uint32_t count = 0;
    bool alone = false;
  };
  struct Out {
    Batch batch;
    WorkClass work;  // known after its request is closed
    WorkerId worker{};
    Time sent;
    Time due;
    Duration patience{0};
    std::optional<Time> expected;  // when its answer should come
    std::uint32_t copies = 0;      // of this batch, made so far
    bool alone = false;
    bool lost = false;       // its worker is: not charged, but an answer still counts
    bool suspected = false;  // lost without a word: counted in losses
    bool answered = false;   // the worker does not hold it any more
  };
  struct Worker {
    std::size_t lanes = 1;
    std::size_t out = 0;      // batches
    std::uint32_t units = 0;  // in them
    Time since{};             // it is at work on them
    bool alone = false;       // holds an isolated unit: gets nothing beside it
  };

  bool may_take(WorkerId id, const Worker& worker, const Range& range) const;
  void wait_again(const Out& out, Loss& loss);
  bool is_apart(const Unit& unit) const;
  void push_waiting(const Range& range);
  void forget_waiting(const Range& range);
  std::optional<Range> take_range(WorkerId id, const Worker& worker, std::uint32_t most);
  Batch send(Worker& worker, WorkerId id, const Range& range, Time now, const Terms& terms);
  Batch keep_home(const Range& range, Time now);
  Out* worth_a_copy(WorkerId worker, Time now, Duration each);
  bool has_unsettled(const Out& out) const;
  bool can_be_copied(const Out& out) const;
  void discharge(const Out& out);
  void settle_unit(Request& request, std::uint32_t unit);
  void suspect(Out& out, LossCause cause, bool at_work, Loss& loss);
  // Null: closed.
  Request* request_of(const Batch& batch);
  const Request* request_of(const Batch& batch) const;
  void drop_settled();

  InFlightLimits limits_;
  std::uint64_t next_batch_ = 1;
  std::deque<Range> queue_;
  std::deque<Unit> apart_;
  std::map<BatchId, Out> out_;
  std::map<WorkerId, Worker> workers_;
  std::map<RequestId, Request> requests_;
  std::optional<WorkerId> kept_free_;   // for an isolated unit
  std::uint32_t unsettled_ = 0;         // units of all
  std::uint32_t waiting_ = 0;           // units in queue_
  std::uint32_t isolated_waiting_ = 0;  // of them, isolated
  bool doubled_ = false;                // a unit may be in two places: queue_ and apart_ can hold settled ones
};

}  // namespace coppice
