#include "common/evolution/front_gauge.hpp"

#include <algorithm>

#include "common/check.hpp"

namespace coppice {
namespace {

constexpr double kUnmeasured = 1e300;  // cost of an individual that could not be evaluated

}  // namespace

FrontGauge::FrontGauge(ScalarFitness fitness, Measuring measuring, const std::vector<Measure>& front)
    : fitness_(std::move(fitness)), measuring_(std::move(measuring)) {
  for (const Measure measure : front) {
    const auto at = std::find(measures().begin(), measures().end(), measure);
    COPPICE_CHECK(at != measures().end());
    compared_.push_back({static_cast<std::size_t>(at - measures().begin()), is_cost(measure) ? 1.0 : -1.0});
  }
}

Result<FrontGauge> FrontGauge::make(const Chain& chain, const EvolveConfig& config) {
  auto fitness = ScalarFitness::make(chain, config.fitness, config.front.objectives);
  if (!fitness) {
    return tl::unexpected(fitness.error());
  }
  auto measuring = Measuring::make(chain, fitness->objectives(), config.rollout.steps);
  if (!measuring) {
    return tl::unexpected(measuring.error());
  }
  return FrontGauge(std::move(*fitness), std::move(*measuring), config.front.objectives);
}

FrontIndividual FrontGauge::of(Individual individual) const {
  FrontIndividual result;
  result.fitness = fitness_.of(individual.tally);
  if (individual.tally.steps == 0) {
    result.costs.assign(compared_.size(), kUnmeasured);
  } else {
    const std::vector<double> values = measuring_.values(individual.tree, individual.tally);
    result.costs.reserve(compared_.size());
    for (const Compared& compared : compared_) {
      result.costs.push_back(compared.sign * values[compared.measure]);
    }
  }
  result.tree = std::move(individual.tree);
  result.tally = std::move(individual.tally);
  return result;
}

std::vector<double> FrontGauge::worth(std::span<const double> weights) const {
  COPPICE_CHECK(weights.size() == compared_.size());
  std::vector<double> worth(objectives().size(), 0.0);
  for (std::size_t cost = 0; cost < weights.size(); ++cost) {
    const Compared& compared = compared_[cost];
    if (is_objective(measures()[compared.measure])) {
      worth[compared.measure] -= weights[cost] * compared.sign * measuring_.slope(compared.measure);
    }
  }
  return worth;
}

}  // namespace coppice
