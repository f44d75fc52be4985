#include "coordinator/dispatch/serial_evaluator.hpp"

namespace coppice {

Result<std::unique_ptr<Evaluator>> SerialEvaluator::make(std::shared_ptr<const Chain> chain, const StopFlag& stop) {
  auto prepared = PreparedChain::make(std::move(chain));
  if (!prepared) {
    return tl::unexpected(prepared.error());
  }
  return std::unique_ptr<Evaluator>(new SerialEvaluator(std::move(*prepared), stop));
}

Result<std::vector<Tally>> SerialEvaluator::evaluate(std::span<const Tree> trees, const Job& job) {
  if (job_ == nullptr || job_->job() != job) {
    auto prepared = PreparedJob::make(chain_, job, job_);
    if (!prepared) {
      return tl::unexpected(prepared.error());
    }
    job_ = std::move(*prepared);
    evaluation_.emplace(job_);
  }
  std::vector<Tally> tallies;
  tallies.reserve(trees.size());
  for (const Tree& tree : trees) {
    if (stop_.raised()) {
      return tl::unexpected(Error{ErrorKind::interrupted, "interrupted"});
    }
    tallies.push_back(evaluation_->evaluate(tree));
  }
  statistics_.individuals += trees.size();
  ++statistics_.batches;
  return tallies;
}

}  // namespace coppice
