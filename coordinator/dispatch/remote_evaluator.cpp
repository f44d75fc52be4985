#include "coordinator/dispatch/remote_evaluator.hpp"

namespace coppice {

Result<std::unique_ptr<RemoteEvaluator>> RemoteEvaluator::open(std::shared_ptr<const Chain> chain,
                                                               RemoteOptions options, const StopFlag& stop) {
  auto dispatch = RemoteDispatch::open(std::move(chain), std::move(options), stop);
  if (!dispatch) {
    return tl::unexpected(dispatch.error());
  }
  return std::unique_ptr<RemoteEvaluator>(new RemoteEvaluator(std::move(*dispatch)));
}

Result<std::vector<Tally>> RemoteEvaluator::evaluate(std::span<const Tree> trees, const Job& job) {
  const auto request = dispatch_->submit(trees, job);
  if (!request) {
    return tl::unexpected(request.error());
  }
  while (!dispatch_->done(*request)) {
    if (auto ok = dispatch_->act(); !ok) {
      dispatch_->abandon();
      return tl::unexpected(ok.error());
    }
    if (!dispatch_->done(*request)) {
      dispatch_->sleep();
    }
  }
  return dispatch_->take(*request).tallies;
}

}  // namespace coppice
