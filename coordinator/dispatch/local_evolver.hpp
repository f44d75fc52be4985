// Runs epochs in this process: on the calling thread, or on several. The fastest path on one machine, and the reference
// that workers must equal bit for bit.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <mutex>
#include <thread>
#include <vector>

#include "common/stop.hpp"
#include "coordinator/dispatch/deme_evolver.hpp"

namespace coppice {

class LocalEvolver : public DemeEvolver {
 public:
  // `stop` outlives it. With one thread epochs run inside next(), one after another. REQUIRES: threads >= 1.
  LocalEvolver(std::shared_ptr<const PreparedChain> chain, std::size_t threads, const StopFlag& stop);
  ~LocalEvolver() override;

  void submit(std::uint64_t ticket, std::shared_ptr<const EvolveConfig> config, EpochTask task) override;
  Result<Finished> next() override;

  // Individuals that were evaluated, and those of them that meant what another did; any thread may ask.
  std::uint64_t individuals() const { return individuals_; }
  std::uint64_t repeated() const { return repeated_; }

 private:
  struct Waiting {
    std::uint64_t ticket = 0;
    std::shared_ptr<const EvolveConfig> config;
    EpochTask task;
  };
  struct Ended {
    std::uint64_t ticket = 0;
    Result<EpochResult> result;
  };

  void work();
  Ended run(EpochRunner& runner, const Waiting& waiting);
  void drop_all();

  const std::shared_ptr<const PreparedChain> chain_;
  const StopFlag& stop_;
  std::atomic<std::uint64_t> individuals_{0};
  std::atomic<std::uint64_t> repeated_{0};
  std::atomic<bool> dropping_{false};  // what runs is not wanted any more
  EpochRunner own_;                    // with one thread

  std::mutex mutex_;  // what follows
  std::condition_variable work_;
  std::condition_variable done_;
  std::deque<Waiting> waiting_;
  std::deque<Ended> ended_;
  std::size_t running_ = 0;
  bool ending_ = false;

  std::vector<std::thread> threads_;
};

}  // namespace coppice
