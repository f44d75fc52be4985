// Evaluates on the calling thread: the fastest serial path, the honest baseline of every speed-up, and the reference
// that remote evaluation must equal bit for bit.
#pragma once

#include <memory>
#include <optional>

#include "common/fitness/evaluation.hpp"
#include "common/stop.hpp"
#include "coordinator/dispatch/evaluator.hpp"

namespace coppice {

class SerialEvaluator : public Evaluator {
 public:
  // `stop` outlives the evaluator. Never fails; a Result because every way to open an evaluator is one.
  static Result<std::unique_ptr<Evaluator>> make(std::shared_ptr<const Chain> chain, const StopFlag& stop);
  // On a chain that several share.
  static std::unique_ptr<Evaluator> make(std::shared_ptr<const PreparedChain> chain, const StopFlag& stop);

  Result<std::vector<Tally>> evaluate(std::span<const Tree> trees, const Job& job) override;
  DispatchStatistics statistics() const override { return statistics_; }

 private:
  SerialEvaluator(std::shared_ptr<const PreparedChain> chain, const StopFlag& stop)
      : chain_(std::move(chain)), stop_(stop) {}

  std::shared_ptr<const PreparedChain> chain_;
  const StopFlag& stop_;
  std::shared_ptr<const PreparedJob> job_;
  std::optional<Evaluation> evaluation_;
  DispatchStatistics statistics_;
};

}  // namespace coppice
