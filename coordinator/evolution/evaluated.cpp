#include "coordinator/evolution/evaluated.hpp"

#include <algorithm>

#include "common/check.hpp"
#include "coordinator/evolution/population.hpp"
#include "coordinator/evolution/selection.hpp"

namespace coppice {

std::size_t Evaluated::best() const { return ranking(trees, fitness).front(); }

Champion Evaluated::champion(std::size_t index, std::uint32_t generation) const {
  return {trees[index], generation, fitness[index], agreement_of(tallies[index])};
}

Result<Evaluated> evaluate(std::vector<Tree> trees, std::uint32_t generation, const EvolveConfig& config,
                           const ScalarFitness& fitness, Evaluator& evaluator) {
  if (trees.empty()) {
    return Evaluated{};
  }
  auto tallies = evaluator.evaluate(trees, job_of(config, fitness.objectives(), generation));
  if (!tallies) {
    return tl::unexpected(std::move(tallies).error());
  }
  COPPICE_CHECK(tallies->size() == trees.size());
  Evaluated result{std::move(trees), std::move(*tallies), {}};
  result.fitness.reserve(result.trees.size());
  for (const Tally& tally : result.tallies) {
    result.fitness.push_back(fitness.of(tally));
  }
  return result;
}

GenerationRecord statistics_of(const Evaluated& population, std::uint32_t generation) {
  GenerationRecord record{.generation = generation, .best = population.champion(population.best(), generation)};
  std::size_t measured = 0;
  for (std::size_t slot = 0; slot < population.trees.size(); ++slot) {
    record.mean_nodes += static_cast<double>(population.trees[slot].size());
    if (population.tallies[slot].steps > 0) {
      ++measured;
      record.mean_fitness += population.fitness[slot];
      record.mean_agreement += agreement_of(population.tallies[slot]);
    }
  }
  record.mean_nodes /= static_cast<double>(population.trees.size());
  record.mean_fitness /= static_cast<double>(std::max<std::size_t>(measured, 1));
  record.mean_agreement /= static_cast<double>(std::max<std::size_t>(measured, 1));
  record.distinct_trees = static_cast<std::uint32_t>(count_distinct(population.trees));
  record.evaluations = population.trees.size();
  return record;
}

}  // namespace coppice
