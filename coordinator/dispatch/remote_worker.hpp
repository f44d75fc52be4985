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
#include "common/wire/topics.hpp"
#include "common/wire/waiter.hpp"
#include "coordinator/dispatch/in_flight.hpp"

namespace coppice {

// What the coordinator puts into every sample.
struct RunIdentity {
  std::uint64_t run_id = 0;
  ChainHash chain;
};

class RemoteWorker {
 public:
  // Makes the writers and has `waiter` watch them. Errors: DDS.
  static Result<RemoteWorker> meet(const wire::Participant& participant, wire::Waiter& waiter,
                                   const wire::Hello& hello);

  WorkerId id() const { return id_; }
  pid_t pid() const { return pid_; }
  std::size_t lanes() const { return lanes_; }
  // "host, pid 123" fit for a terminal.
  const std::string& name() const { return name_; }

  // Takes what a Hello says about the run, its chain, and how far the worker got.
  void hear(const wire::Hello& hello, const RunIdentity& run, InFlight::Time now);
  // Since when its count of evaluated individuals stands still, or since it was last given something to do.
  InFlight::Time progressed() const { return progressed_; }
  // Holds the chain, serves this run, and can be written to.
  bool ready() const { return holds_chain_ && tasks_matched_; }
  // Looks whether its readers are there; until then what woke the waiter goes on waking it.
  void look();
  void lacks_chain() { holds_chain_ = false; }

  // Remembers which blocks it asked for; send_blocks() sends them once the worker can hear.
  void request_blocks(std::uint32_t first, std::uint32_t count);
  // Returns how many blocks were sent.
  std::size_t send_blocks(std::span<const std::uint8_t> chain_bytes, const RunIdentity& run);

  Result<void> send_task(const Batch& batch, std::span<const std::uint8_t> payload, const RunIdentity& run,
                         InFlight::Time now);

  // Cost of one individual in `steps` walked steps, smoothed over answers; 0 before the first.
  void measured(std::chrono::nanoseconds elapsed, std::uint32_t individuals, std::uint64_t steps);
  std::chrono::nanoseconds cost_of(std::uint64_t steps) const;

 private:
  RemoteWorker(const wire::Hello& hello, wire::Writer<wire::Task> tasks, wire::Writer<wire::ChainBlock> blocks);

  WorkerId id_;
  pid_t pid_;
  std::size_t lanes_;
  std::string name_;
  wire::Writer<wire::Task> tasks_;
  wire::Writer<wire::ChainBlock> blocks_;
  bool tasks_matched_ = false;
  bool blocks_matched_ = false;
  bool holds_chain_ = false;
  struct Blocks {
    std::uint32_t first = 0;
    std::uint32_t count = 0;
  };
  std::optional<Blocks> requested_;
  double ns_per_step_ = 0.0;
  std::uint64_t evaluated_ = 0;
  InFlight::Time progressed_;
};

}  // namespace coppice
