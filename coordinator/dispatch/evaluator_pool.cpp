#include "coordinator/dispatch/evaluator_pool.hpp"

#include <utility>

namespace coppice {

class EvaluatorPool::Client : public Evaluator {
 public:
  explicit Client(EvaluatorPool& pool) : pool_(pool) {}

  Result<std::vector<Tally>> evaluate(std::span<const Tree> trees, const Job& job) override {
    auto finished = pool_.evaluate(trees, job);
    if (!finished) {
      return tl::unexpected(finished.error());
    }
    statistics_.individuals += trees.size();
    statistics_.repeated += finished->repeated;
    return std::move(finished->tallies);
  }
  DispatchStatistics statistics() const override { return statistics_; }

 private:
  EvaluatorPool& pool_;
  DispatchStatistics statistics_;
};

Result<std::unique_ptr<EvaluatorPool>> EvaluatorPool::open(std::shared_ptr<const Chain> chain, RemoteOptions options,
                                                           const StopFlag& stop) {
  auto dispatch = RemoteDispatch::open(std::move(chain), std::move(options), stop);
  if (!dispatch) {
    return tl::unexpected(dispatch.error());
  }
  return std::unique_ptr<EvaluatorPool>(new EvaluatorPool(std::move(*dispatch)));
}

EvaluatorPool::EvaluatorPool(std::unique_ptr<RemoteDispatch> dispatch)
    : dispatch_(std::move(dispatch)), thread_([this] { run(); }) {}

EvaluatorPool::~EvaluatorPool() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  dispatch_->wake();
  thread_.join();
}

std::unique_ptr<Evaluator> EvaluatorPool::client() { return std::make_unique<Client>(*this); }

DispatchStatistics EvaluatorPool::statistics() const {
  const std::lock_guard lock(mutex_);
  return statistics_;
}

Result<RemoteRequests::Finished> EvaluatorPool::evaluate(std::span<const Tree> trees, const Job& job) {
  Call call;
  call.trees = trees;
  call.job = &job;
  std::unique_lock lock(mutex_);
  if (broken_) {
    return tl::unexpected(*broken_);
  }
  const bool first = calls_.empty();
  calls_.push_back(&call);
  if (first) {
    dispatch_->wake();
  }
  call.answered.wait(lock, [&] { return call.result.has_value(); });
  return std::move(*call.result);
}

// The call is gone as soon as its mutex is free: its owner is told before.
void EvaluatorPool::answer(Call& call, Result<RemoteRequests::Finished> result) {
  call.result = std::move(result);
  call.answered.notify_one();
}

void EvaluatorPool::run() {
  while (true) {
    take_calls();
    {
      const std::lock_guard lock(mutex_);
      if (ending_ || broken_) {
        return;
      }
    }
    if (auto ok = dispatch_->act(); !ok) {
      fail_calls(ok.error());
      return;
    }
    answer_calls();
    dispatch_->sleep();
  }
}

void EvaluatorPool::take_calls() {
  const std::lock_guard lock(mutex_);
  for (Call* const call : std::exchange(calls_, {})) {
    if (const auto request = dispatch_->submit(call->trees, *call->job)) {
      open_.emplace(*request, call);
    } else {
      answer(*call, tl::unexpected(request.error()));
    }
  }
}

void EvaluatorPool::answer_calls() {
  for (auto open = open_.begin(); open != open_.end();) {
    if (!dispatch_->done(open->first)) {
      ++open;
      continue;
    }
    auto finished = dispatch_->take(open->first);
    const DispatchStatistics statistics = dispatch_->statistics();
    const std::lock_guard lock(mutex_);
    statistics_ = statistics;
    answer(*open->second, std::move(finished));
    open = open_.erase(open);
  }
}

void EvaluatorPool::fail_calls(const Error& error) {
  dispatch_->abandon();
  const std::lock_guard lock(mutex_);
  broken_ = error;
  for (const auto& [request, call] : open_) {
    answer(*call, tl::unexpected(error));
  }
  for (Call* const call : calls_) {
    answer(*call, tl::unexpected(error));
  }
  open_.clear();
  calls_.clear();
}

}  // namespace coppice
