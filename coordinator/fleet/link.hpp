// What one worker is written to with: writers of its own (one partition a worker, so that a stopped one blocks nobody).
// It knows whether what is written arrives. Belongs to the thread of its Fleet.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>

#include "common/chain/chain_bytes.hpp"
#include "common/error.hpp"
#include "common/wire/topics.hpp"
#include "common/wire/waiter.hpp"
#include "coordinator/dispatch/work.hpp"

namespace coppice {

// What the coordinator puts into every sample.
struct RunIdentity {
  std::uint64_t run_id = 0;
  ChainHash chain;
};

class Link {
 public:
  using Time = std::chrono::steady_clock::time_point;

  // Makes the writers and has `waiter` watch them. Errors: DDS.
  static Result<Link> open(const wire::Participant& participant, wire::Waiter& waiter, WorkerId worker);

  // Tasks arrive.
  bool settled() const { return task_match_.settled; }
  // Its readers are there, but not yet ready to hear.
  bool settling() const { return task_match_.settling() || block_match_.settling(); }
  // Looks whether its readers are there; until then what woke the waiter goes on waking it. True: settled() changed.
  bool look(Time now);

  // Remembers which blocks it asked for; send_blocks() sends them once the worker can hear.
  void request_blocks(std::uint32_t first, std::uint32_t count);
  void send_blocks(std::span<const std::uint8_t> chain_bytes, const RunIdentity& run);

  Result<void> send_task(BatchId batch, WorkKind work, std::span<const std::uint8_t> payload, const RunIdentity& run);

 private:
  // Of a writer with the worker's reader.
  struct Match {
    std::optional<Time> since;
    bool settled = false;  // what is written arrives
    bool settling() const { return since.has_value() && !settled; }
    void look(bool matched, Time now);
  };

  Link(wire::Writer<wire::Task> tasks, wire::Writer<wire::ChainBlock> blocks)
      : tasks_(std::move(tasks)), blocks_(std::move(blocks)) {}

  wire::Writer<wire::Task> tasks_;
  wire::Writer<wire::ChainBlock> blocks_;
  Match task_match_;
  Match block_match_;
  struct Blocks {
    std::uint32_t first = 0;
    std::uint32_t count = 0;
  };
  std::optional<Blocks> requested_;
};

}  // namespace coppice
