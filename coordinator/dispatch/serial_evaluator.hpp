// Evaluates on the calling thread, and runs demes on as many as it is given: the fastest serial path, the honest
// baseline of every speed-up, and the reference that remote evaluation must equal bit for bit.
#pragma once

#include <memory>
#include <optional>

#include "common/fitness/evaluation.hpp"
#include "common/stop.hpp"
#include "coordinator/dispatch/evaluator.hpp"
#include "coordinator/dispatch/local_evolver.hpp"

namespace coppice {

class SerialEvaluator : public Evaluator {
 public:
  // `stop` outlives the evaluator. Epochs of demes run on `threads` threads, at least 1. Never fails; a Result because
  // every way to open an evaluator is one.
  static Result<std::unique_ptr<Evaluator>> make(std::shared_ptr<const Chain> chain, const StopFlag& stop,
                                                 std::size_t threads = 1);
  // On a chain that several share.
  static std::unique_ptr<Evaluator> make(std::shared_ptr<const PreparedChain> chain, const StopFlag& stop,
                                         std::size_t threads = 1);

  Result<std::vector<Tally>> evaluate(std::span<const Tree> trees, const Job& job) override;
  DemeEvolver* demes(const EvolveConfig& config) override;
  DispatchStatistics statistics() const override;

 private:
  SerialEvaluator(std::shared_ptr<const PreparedChain> chain, const StopFlag& stop, std::size_t threads)
      : chain_(std::move(chain)), stop_(stop), threads_(threads) {}

  std::shared_ptr<const PreparedChain> chain_;
  const StopFlag& stop_;
  const std::size_t threads_;
  std::shared_ptr<const PreparedJob> job_;
  std::optional<Evaluation> evaluation_;
  DispatchStatistics statistics_;
  std::optional<LocalEvolver> demes_;  // once there are any
};

}  // namespace coppice
