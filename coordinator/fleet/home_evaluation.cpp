#include "coordinator/fleet/home_evaluation.hpp"

#include <algorithm>
#include <thread>

#include "coordinator/fleet/evaluation_work.hpp"

namespace coppice {

HomeEvaluation::HomeEvaluation(Evaluator& evaluator)
    : evaluator_(evaluator), choice_(std::max(1U, std::thread::hardware_concurrency())) {}

Result<std::optional<std::vector<Tally>>> HomeEvaluation::evaluate(std::span<const Tree> trees, const Job& job,
                                                                   std::size_t lanes) {
  using Clock = std::chrono::steady_clock;
  if (trees.empty()) {
    return std::nullopt;
  }
  const WorkClass work = EvaluationWork::class_of(job);
  const auto units = static_cast<std::uint32_t>(trees.size());
  auto way = choice_.way(work, units, lanes);
  if (way == HomeChoice::Way::probe) {
    const std::uint32_t some = std::min(units, HomeChoice::kProbe);
    const auto begin = Clock::now();
    if (auto tallies = evaluator_.evaluate(trees.first(some), job); !tallies) {
      return tl::unexpected(tallies.error());
    }
    choice_.probed(work, some, Clock::now() - begin);
    way = choice_.way(work, units, lanes);
  }
  if (way != HomeChoice::Way::home) {
    return std::nullopt;
  }
  const std::uint64_t repeated = evaluator_.statistics().repeated;
  const auto begin = Clock::now();
  auto tallies = evaluator_.evaluate(trees, job);
  if (!tallies) {
    return tl::unexpected(tallies.error());
  }
  choice_.took_home(work, units, Clock::now() - begin);
  statistics_.individuals += units;
  statistics_.at_home += units;
  statistics_.repeated += evaluator_.statistics().repeated - repeated;
  return std::move(*tallies);
}

bool HomeEvaluation::would_gain(std::size_t trees, const Job& job, std::size_t lanes) {
  return choice_.would_gain(EvaluationWork::class_of(job), static_cast<std::uint32_t>(trees), lanes);
}

void HomeEvaluation::took_workers(std::size_t trees, const Job& job, std::chrono::nanoseconds elapsed) {
  if (trees > 0) {
    choice_.took_workers(EvaluationWork::class_of(job), static_cast<std::uint32_t>(trees), elapsed);
  }
}

}  // namespace coppice
