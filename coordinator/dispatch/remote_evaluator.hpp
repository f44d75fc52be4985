// Evaluates on worker processes over DDS, one generation at a time: RemoteDispatch on the caller's thread.
#pragma once

#include "coordinator/dispatch/remote_dispatch.hpp"

namespace coppice {

class RemoteEvaluator : public Evaluator {
 public:
  // `stop` outlives the evaluator. Errors: RemoteDispatch::open().
  static Result<std::unique_ptr<RemoteEvaluator>> open(std::shared_ptr<const Chain> chain, RemoteOptions options,
                                                       const StopFlag& stop);

  Result<std::vector<Tally>> evaluate(std::span<const Tree> trees, const Job& job) override;
  DispatchStatistics statistics() const override { return dispatch_->statistics(); }

  std::uint32_t domain() const { return dispatch_->domain(); }
  std::vector<pid_t> ready_pids() const { return dispatch_->ready_pids(); }
  Result<void> await_workers(std::size_t count) { return dispatch_->await_workers(count); }

 private:
  explicit RemoteEvaluator(std::unique_ptr<RemoteDispatch> dispatch) : dispatch_(std::move(dispatch)) {}

  std::unique_ptr<RemoteDispatch> dispatch_;
};

}  // namespace coppice
