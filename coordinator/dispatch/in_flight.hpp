// Who has which slots: the bookkeeping of generations on their way through the workers, one or several at a time,
// without DDS, threads or clocks of its own (time is passed in), so that every fault can be tested as a sequence of
// calls.
//
// The life of a slot: waiting -> offered to a worker in a batch -> settled by the first answer that names it. A
// lost worker's slots wait again, at the front; when nothing waits, a batch that is overdue, or that an idle worker
// would have done long before its own, may be offered to a second worker as a copy.
// Because a tally is a pure function of its slot, it does not matter which answer comes first.
//
// Generations are served in the order in which they began. A batch holds slots of one generation.
//
// Invariant: every slot of a generation is settled, or waiting, or in a batch that is out.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <vector>

namespace coppice {

enum class WorkerId : std::uint64_t {};
enum class BatchId : std::uint64_t {};
enum class GenerationId : std::uint64_t {};

struct InFlightLimits {
  std::size_t ahead = 1;            // batches out at a worker beyond those at work, to hide the way there
  std::uint32_t attempts = 5;       // workers that may be lost with a slot before it counts as poisonous
  std::uint32_t isolate_after = 2;  // lost workers after which a slot travels alone
  std::uint32_t copies = 2;         // of one batch; a copy is not copied
};

// Slots first .. first + count - 1 of a generation.
struct Batch {
  BatchId id{};
  GenerationId generation{};
  std::uint32_t first = 0;
  std::uint32_t count = 0;
};

struct Slot {
  GenerationId generation{};
  std::uint32_t index = 0;
  bool operator==(const Slot&) const = default;
};

class InFlight {
 public:
  using Time = std::chrono::steady_clock::time_point;
  using Duration = std::chrono::steady_clock::duration;

  explicit InFlight(const InFlightLimits& limits) : limits_(limits) {}

  // Starts a generation of `slots`.
  GenerationId begin(std::uint32_t slots);
  // Forgets a generation, settled or not. What is still out of it stays charged to its worker until answered.
  void end(GenerationId generation);

  // A worker with so many evaluating threads. One that was lost and is back did not die after all: what it held is
  // cleared of suspicion. REQUIRES: lanes >= 1.
  void add_worker(WorkerId worker, std::size_t lanes = 1);
  bool has_worker(WorkerId worker) const { return workers_.count(worker) != 0; }
  std::size_t workers() const { return workers_.size(); }
  // Batches out at a worker, copies and leftovers of earlier generations included; and the slots in them.
  std::size_t load(WorkerId worker) const;
  std::uint32_t backlog(WorkerId worker) const;
  // How long the worker is busy with them, if an individual takes `each`; 0 when it should have answered already.
  Duration remaining(WorkerId worker, Time now, Duration each) const;

  // What may be expected of a worker.
  struct Terms {
    Duration patience{0};  // after it a batch is overdue
    Duration each{0};      // an individual takes it; 0: not known
  };
  // Whether offer() could hand this worker anything.
  bool can_take(WorkerId worker) const;
  // Takes at most `most` waiting slots for the worker. None when nothing waits that it may take, or its credit is used
  // up. REQUIRES: has_worker(worker), most >= 1.
  std::optional<Batch> offer(WorkerId worker, std::uint32_t most, Time now, const Terms& terms);
  // Nothing waits and a lane is idle: a copy of the batch out at somebody else that is overdue longest, or else of
  // the one that is expected last, if the idle lane would have it in less than half that time. What a worker of unknown
  // pace holds is overdue when the idle one would have done it several times.
  // REQUIRES: has_worker(worker).
  std::optional<Batch> offer_copy(WorkerId worker, Time now, const Terms& terms);
  // Workers with a batch that is overdue.
  std::set<WorkerId> late(Time now) const;
  // When the next batch becomes overdue, if any is out.
  std::optional<Time> next_due() const;

  enum class Settled : std::uint8_t { first, duplicate, foreign };
  struct Settlement {
    Settled kind = Settled::foreign;
    Batch batch;                       // unless foreign
    std::vector<std::uint32_t> fresh;  // slots that this answer settled
  };
  // An answer. Late answers of lost workers settle too; foreign: no such batch is out at that worker.
  Settlement settle(BatchId batch, WorkerId worker, Time now);
  // The batch as it went out to that worker, to check an answer against before it settles anything. `current`: its
  // generation has not ended, else its answer settles nothing.
  struct Found {
    Batch batch;
    bool current = false;
    Time sent;
  };
  std::optional<Found> find(BatchId batch, WorkerId worker) const;
  // The worker returned the batch unevaluated; its slots wait again, at the front. False: foreign.
  bool give_back(BatchId batch, WorkerId worker);

  struct Loss {
    std::size_t batches = 0;
    std::vector<Slot> poisonous;  // settled by giving up: too many workers were lost with them
  };
  // The worker died, is out of reach, or left in order; its slots wait again, at the front. Answers that still come
  // from it count. Only a worker that did not leave in order casts suspicion on what it held.
  enum class Farewell : std::uint8_t { died, left };
  Loss lose_worker(WorkerId worker, Farewell farewell);

  // All generations that have not ended are settled; or this one.
  bool done() const { return unsettled_ == 0; }
  bool done(GenerationId generation) const { return generations_.at(generation).unsettled == 0; }
  std::uint32_t unsettled() const { return unsettled_; }
  std::uint32_t waiting() const { return waiting_; }
  // Whose slots go out next.
  std::optional<GenerationId> front() const;

 private:
  struct Generation {
    std::vector<bool> settled;
    std::vector<std::uint32_t> attempts;
    std::uint32_t unsettled = 0;
  };
  struct Range {
    GenerationId generation{};
    std::uint32_t first = 0;
    std::uint32_t count = 0;
    bool alone = false;
  };
  struct Out {
    Batch batch;
    WorkerId worker{};
    Time sent;
    Time due;
    std::optional<Time> expected;  // when its answer should come
    std::uint32_t copies = 0;      // of this batch, made so far
    bool alone = false;
    bool lost = false;       // its worker is: not charged, but an answer still counts
    bool suspected = false;  // lost by death: counted in attempts
  };
  struct Worker {
    std::size_t lanes = 1;
    std::size_t out = 0;      // batches
    std::uint32_t slots = 0;  // in them
    Time since{};             // it is at work on them
    bool alone = false;       // holds an isolated slot: gets nothing beside it
  };

  bool may_take(const Worker& worker, const Range& range) const;
  void wait_again(const Out& out);
  void push_waiting(const Range& range);
  std::optional<Range> take_range(const Worker& worker, std::uint32_t most);
  Batch send(Worker& worker, WorkerId id, const Range& range, Time now, const Terms& terms);
  Out* worth_a_copy(WorkerId worker, Time now, Duration each);
  bool has_unsettled(const Out& out) const;
  bool can_be_copied(const Out& out) const;
  bool is_held_elsewhere(const Slot& slot) const;
  void discharge(const Out& out);
  void settle_slot(Generation& generation, std::uint32_t slot);
  // Null: ended.
  Generation* generation_of(const Batch& batch);
  const Generation* generation_of(const Batch& batch) const;
  void drop_settled();

  InFlightLimits limits_;
  std::uint64_t next_generation_ = 1;
  std::uint64_t next_batch_ = 1;
  std::deque<Range> queue_;
  std::map<BatchId, Out> out_;
  std::map<WorkerId, Worker> workers_;
  std::map<GenerationId, Generation> generations_;
  std::uint32_t unsettled_ = 0;  // slots of all
  std::uint32_t waiting_ = 0;    // slots in queue_
  bool doubled_ = false;         // a slot may be in two places: queue_ can hold settled ones
};

}  // namespace coppice
