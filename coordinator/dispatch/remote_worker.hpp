// One worker as the coordinator sees it: who it is, its own writers (one partition a worker, so that a stopped one
// blocks nobody), how far it got with the chain, and its measured pace. Belongs to the remote evaluator's thread.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <sys/types.h>

#include "common/chain/chain_bytes.hpp"
#include "common/error.hpp"
#include "common/wire/origin.hpp"
#include "common/wire/topics.hpp"
#include "common/wire/waiter.hpp"
#include "coordinator/dispatch/in_flight.hpp"
#include "coordinator/dispatch/measured_pace.hpp"

namespace coppice {

// What the coordinator puts into every sample.
struct RunIdentity {
  std::uint64_t run_id = 0;
  ChainHash chain;
};

class RemoteWorker {
 public:
  // Makes the writers and has `waiter` watch them. `origin`: of the Hello. Errors: DDS.
  static Result<RemoteWorker> meet(const wire::Participant& participant, wire::Waiter& waiter, const wire::Hello& hello,
                                   const wire::Origin& origin);

  WorkerId id() const { return id_; }
  // Who alone may speak for it.
  const wire::Origin& origin() const { return origin_; }
  pid_t pid() const { return pid_; }
  std::size_t lanes() const { return lanes_; }
  // "host, pid 123" fit for a terminal.
  const std::string& name() const { return name_; }

  // For those who look on. `batches`: in its hands.
  wire::WorkerStatus status(std::size_t batches, InFlight::Time now) const;

  // Takes what a Hello says about the run, its chain, and how far the worker got.
  void hear(const wire::Hello& hello, const RunIdentity& run, InFlight::Time now);
  // Since when its count of evaluated individuals stands still, or since it was last given something to do.
  InFlight::Time progressed() const { return progressed_; }
  // Holds the chain, serves this run, and can be written to.
  bool ready() const { return holds_chain_ && task_match_.settled; }
  // Its readers are there, but not yet ready to hear.
  bool settling() const { return task_match_.settling() || block_match_.settling(); }
  // Looks whether its readers are there; until then what woke the waiter goes on waking it.
  void look(InFlight::Time now);
  void lacks_chain() { holds_chain_ = false; }

  // Remembers which blocks it asked for; send_blocks() sends them once the worker can hear.
  void request_blocks(std::uint32_t first, std::uint32_t count);
  // Returns how many blocks were sent.
  std::size_t send_blocks(std::span<const std::uint8_t> chain_bytes, const RunIdentity& run);

  Result<void> send_task(const Batch& batch, std::span<const std::uint8_t> payload, const RunIdentity& run,
                         InFlight::Time now);

  MeasuredPace& pace() { return pace_; }
  const MeasuredPace& pace() const { return pace_; }

 private:
  // Of a writer with the worker's reader.
  struct Match {
    std::optional<InFlight::Time> since;
    bool settled = false;  // what is written arrives
    bool settling() const { return since.has_value() && !settled; }
    void look(bool matched, InFlight::Time now);
  };

  RemoteWorker(const wire::Hello& hello, const wire::Origin& origin, wire::Writer<wire::Task> tasks,
               wire::Writer<wire::ChainBlock> blocks);

  WorkerId id_;
  wire::Origin origin_;
  pid_t pid_;
  wire::WorkerStatus status_{};  // what stays the same, or was said last
  InFlight::Time heard_;
  struct Pace {  // individuals a second, over kPaceWindow
    InFlight::Time since;
    std::uint64_t evaluated = 0;
    std::uint64_t each_second = 0;
  };
  Pace lately_;
  std::size_t lanes_;
  std::string name_;
  wire::Writer<wire::Task> tasks_;
  wire::Writer<wire::ChainBlock> blocks_;
  Match task_match_;
  Match block_match_;
  bool holds_chain_ = false;
  struct Blocks {
    std::uint32_t first = 0;
    std::uint32_t count = 0;
  };
  std::optional<Blocks> requested_;
  MeasuredPace pace_;
  std::uint64_t evaluated_ = 0;
  InFlight::Time progressed_;
};

}  // namespace coppice
