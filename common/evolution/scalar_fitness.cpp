#include "common/evolution/scalar_fitness.hpp"

#include <algorithm>

#include "common/check.hpp"

namespace coppice {

double agreement_of(const Tally& tally) {
  return tally.steps == 0 ? 0.0 : static_cast<double>(tally.matches) / static_cast<double>(tally.steps);
}

Result<ScalarFitness> ScalarFitness::make(const Chain& chain, const FitnessConfig& fitness,
                                          std::span<const Measure> also) {
  auto objectives = objectives_of(fitness, chain.vocabulary(), also);
  if (!objectives) {
    return tl::unexpected(objectives.error());
  }
  ScalarFitness result(fitness, std::move(*objectives));
  for (const Objective& objective : result.objectives_) {
    const auto table = make_score_table(chain, objective);
    if (!table) {
      return tl::unexpected(table.error());
    }
    // best_per_step is 1 at the least, even where every score is negative.
    result.best_.push_back(table->best_per_step > 1 ? static_cast<double>(table->best_per_step) : table->unit);
  }
  return result;
}

double ScalarFitness::of(const Tally& tally) const {
  COPPICE_CHECK(tally.scores.size() == objectives_.size());
  if (tally.steps == 0) {
    return kNone;
  }
  double sum = 0.0;
  for (std::size_t i = 0; i < objectives_.size(); ++i) {
    const double steps = along_walk(objectives_[i].kind) ? static_cast<double>(tally.steps) : 1.0;
    const double sign = is_cost(objectives_[i].kind) ? -1.0 : 1.0;
    sum += sign * fitness_.weight(objectives_[i].kind) * (static_cast<double>(tally.scores[i]) / (best_[i] * steps));
  }
  if (agreement_of(tally) > fitness_.size_threshold) {
    sum += fitness_.size_weight * std::min(1.0, fitness_.size_nodes / static_cast<double>(tally.nodes));
  }
  return sum;
}

}  // namespace coppice
