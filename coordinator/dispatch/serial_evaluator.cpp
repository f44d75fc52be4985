#include "coordinator/dispatch/serial_evaluator.hpp"

#include <algorithm>
#include <iterator>

namespace coppice {

Result<std::unique_ptr<Evaluator>> SerialEvaluator::make(std::shared_ptr<const Chain> chain, const StopFlag& stop,
                                                         std::size_t threads) {
  return make(PreparedChain::make(std::move(chain)), stop, threads);
}

std::unique_ptr<Evaluator> SerialEvaluator::make(std::shared_ptr<const PreparedChain> chain, const StopFlag& stop,
                                                 std::size_t threads) {
  return std::unique_ptr<Evaluator>(new SerialEvaluator(std::move(chain), stop, threads));
}

DemeEvolver* SerialEvaluator::demes(const EvolveConfig&) {
  if (!demes_) {
    demes_.emplace(chain_, threads_, stop_);
  }
  return &*demes_;
}

DispatchStatistics SerialEvaluator::statistics() const {
  DispatchStatistics all = statistics_;
  if (demes_) {
    all.individuals += demes_->individuals();
    all.repeated += demes_->repeated();
  }
  return all;
}

Result<std::vector<Tally>> SerialEvaluator::evaluate(std::span<const Tree> trees, const Job& job) {
  if (job_ == nullptr || job_->job() != job) {
    auto prepared = PreparedJob::make(chain_, job, job_);
    if (!prepared) {
      return tl::unexpected(prepared.error());
    }
    job_ = std::move(*prepared);
    evaluation_ ? evaluation_->begin(job_) : static_cast<void>(evaluation_.emplace(job_));
  }
  std::vector<Tally> tallies;
  tallies.reserve(trees.size());
  const std::uint64_t repeated = evaluation_->repeated();
  // A few passes at a time: what repeats leaves no lane idle, and the stop flag is seen soon.
  const std::size_t most = std::size_t{4} * evaluation_->trees_per_pass();
  while (tallies.size() < trees.size()) {
    if (stop_.raised()) {
      return interrupted();
    }
    const std::size_t count = std::min(most, trees.size() - tallies.size());
    auto some = evaluation_->evaluate(trees.subspan(tallies.size(), count));
    std::move(some.begin(), some.end(), std::back_inserter(tallies));
  }
  statistics_.repeated += evaluation_->repeated() - repeated;
  statistics_.individuals += trees.size();
  ++statistics_.batches;
  return tallies;
}

}  // namespace coppice
