#include "coordinator/dispatch/local_evolver.hpp"

#include <utility>

#include "common/check.hpp"

namespace coppice {

LocalEvolver::LocalEvolver(std::shared_ptr<const PreparedChain> chain, std::size_t threads, const StopFlag& stop)
    : chain_(std::move(chain)), stop_(stop), own_(chain_) {
  COPPICE_CHECK(threads >= 1);
  for (std::size_t i = 0; threads > 1 && i < threads; ++i) {
    threads_.emplace_back([this] { work(); });
  }
}

LocalEvolver::~LocalEvolver() {
  dropping_ = true;
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  work_.notify_all();
  for (std::thread& thread : threads_) {
    thread.join();
  }
}

void LocalEvolver::submit(std::uint64_t ticket, std::shared_ptr<const EvolveConfig> config, EpochTask task) {
  {
    const std::lock_guard lock(mutex_);
    waiting_.push_back({ticket, std::move(config), std::move(task)});
  }
  work_.notify_one();
}

Result<DemeEvolver::Finished> LocalEvolver::next() {
  std::unique_lock lock(mutex_);
  COPPICE_CHECK(!waiting_.empty() || !ended_.empty() || running_ > 0);
  if (threads_.empty()) {
    const Waiting waiting = std::move(waiting_.front());
    waiting_.pop_front();
    ended_.push_back(run(own_, waiting));
  }
  done_.wait(lock, [this] { return !ended_.empty(); });
  Ended ended = std::move(ended_.front());
  ended_.pop_front();
  lock.unlock();
  if (!ended.result) {
    drop_all();
    return tl::unexpected(std::move(ended.result).error());
  }
  return Finished{ended.ticket, std::move(*ended.result)};
}

void LocalEvolver::work() {
  EpochRunner runner(chain_);
  std::unique_lock lock(mutex_);
  while (true) {
    work_.wait(lock, [this] { return ending_ || !waiting_.empty(); });
    if (ending_) {
      return;
    }
    const Waiting waiting = std::move(waiting_.front());
    waiting_.pop_front();
    ++running_;
    lock.unlock();
    Ended ended = run(runner, waiting);
    lock.lock();
    --running_;
    ended_.push_back(std::move(ended));
    done_.notify_one();
  }
}

LocalEvolver::Ended LocalEvolver::run(EpochRunner& runner, const Waiting& waiting) {
  const std::uint64_t repeated = runner.repeated();
  auto result = runner.run(*waiting.config, waiting.task, [this](std::size_t evaluated) {
    individuals_ += evaluated;
    return !stop_.raised() && !dropping_;
  });
  repeated_ += runner.repeated() - repeated;
  return {waiting.ticket, std::move(result)};
}

void LocalEvolver::drop_all() {
  dropping_ = true;
  std::unique_lock lock(mutex_);
  waiting_.clear();
  done_.wait(lock, [this] { return running_ == 0; });
  ended_.clear();
  dropping_ = false;
}

}  // namespace coppice
