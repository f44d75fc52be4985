// Evaluation by the coordinator itself beside its workers, where sending would take longer (HomeChoice). The tallies
// are the same either way. Belongs to one thread.
#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "coordinator/dispatch/evaluator.hpp"
#include "coordinator/dispatch/home_choice.hpp"

namespace coppice {

class HomeEvaluation {
 public:
  // `evaluator` is a serial one, and outlives this.
  explicit HomeEvaluation(Evaluator& evaluator);

  // `lanes` of workers are ready. Empty: they are to do it. Errors: as Evaluator::evaluate().
  Result<std::optional<std::vector<Tally>>> evaluate(std::span<const Tree> trees, const Job& job, std::size_t lanes);
  // Whether so many computing threads of workers, once there, would be sooner done with another such request.
  bool would_gain(std::size_t trees, const Job& job, std::size_t lanes);
  // What evaluate() left to the workers took so long, for the next choice.
  void took_workers(std::size_t trees, const Job& job, std::chrono::nanoseconds elapsed);
  // individuals, at_home and repeated: of what was evaluated here.
  const DispatchStatistics& statistics() const { return statistics_; }

 private:
  Evaluator& evaluator_;
  HomeChoice choice_;
  DispatchStatistics statistics_;
};

}  // namespace coppice
