// The floor under dispatch: batches of given sizes sent to workers that answer at once with given sizes
// (coppice-worker --echo), by a bare loop over the same topics, without books, trees or chain. What the remote
// evaluator takes beyond this it spends itself. One thread uses it.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

#include "common/error.hpp"
#include "common/stop.hpp"
#include "coordinator/fleet/endpoints.hpp"
#include "coordinator/fleet/local_workers.hpp"

namespace coppice {

class Echo {
 public:
  // Starts the workers, the first of them with these flags, and waits until all are there. `stop` outlives it. Errors:
  // as FleetEvaluator::open(); workers that do not come within kPatience; interrupted.
  static Result<std::unique_ptr<Echo>> open(const std::filesystem::path& worker_program, std::size_t workers,
                                            const StopFlag& stop, const wire::Network& network = {},
                                            std::vector<LocalWorkers::Flags> flags = {});
  ~Echo() = default;
  Echo(const Echo&) = delete;
  Echo& operator=(const Echo&) = delete;

  static constexpr std::chrono::seconds kPatience{30};  // for workers to come, and for one exchange

  struct Traffic {
    std::size_t batches = 0;
    std::size_t task_bytes = 0;    // each
    std::size_t answer_bytes = 0;  // each
    std::size_t ahead = 2;         // out at a worker
  };
  // What a chain of so many bytes is sent as: its blocks, as many ahead as a worker asks for, hardly an answer.
  static Traffic chain_traffic(std::uint64_t bytes);
  // Sends the batches in turn to all workers, `ahead` at a time to each, and returns when all are answered. Errors: as
  // open(). REQUIRES: both sizes within the contract's bounds, ahead at most wire::kTaskDepth.
  Result<void> exchange(const Traffic& traffic);

 private:
  using Clock = std::chrono::steady_clock;
  struct Peer {
    std::uint64_t worker = 0;
    wire::Writer<wire::Task> tasks;
    std::size_t out = 0;
  };

  Echo(Endpoints endpoints, LocalWorkers local, const StopFlag& stop);

  Result<void> meet(const wire::Hello& hello);
  Result<void> await_peers(std::size_t count);
  // Errors: past `limit`, or interrupted.
  Result<void> sleep(Clock::time_point limit);

  Endpoints dds_;
  const StopFlag& stop_;
  StopFlag::Wake wake_;
  std::uint64_t run_id_;
  std::vector<Peer> peers_;
  LocalWorkers local_;
};

}  // namespace coppice
