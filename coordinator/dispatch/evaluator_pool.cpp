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

Result<RemoteDispatch::Finished> EvaluatorPool::evaluate(std::span<const Tree> trees, const Job& job) {
  Call call{trees, &job, std::nullopt};
  std::unique_lock lock(mutex_);
  if (broken_) {
    return tl::unexpected(*broken_);
  }
  const bool first = calls_.empty();
  calls_.push_back(&call);
  if (first) {
    dispatch_->wake();
  }
  answered_.wait(lock, [&] { return call.result.has_value(); });
  return std::move(*call.result);
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
      call->result = tl::unexpected(request.error());
      answered_.notify_all();
    }
  }
}

void EvaluatorPool::answer_calls() {
  bool some = false;
  for (auto open = open_.begin(); open != open_.end();) {
    if (!dispatch_->done(open->first)) {
      ++open;
      continue;
    }
    auto finished = dispatch_->take(open->first);
    const std::lock_guard lock(mutex_);
    open->second->result = std::move(finished);
    open = open_.erase(open);
    some = true;
  }
  if (some) {
    const DispatchStatistics statistics = dispatch_->statistics();
    {
      const std::lock_guard lock(mutex_);
      statistics_ = statistics;
    }
    answered_.notify_all();
  }
}

void EvaluatorPool::fail_calls(const Error& error) {
  dispatch_->abandon();
  const std::lock_guard lock(mutex_);
  broken_ = error;
  for (const auto& [request, call] : open_) {
    call->result = tl::unexpected(error);
  }
  for (Call* const call : calls_) {
    call->result = tl::unexpected(error);
  }
  open_.clear();
  calls_.clear();
  answered_.notify_all();
}

}  // namespace coppice
