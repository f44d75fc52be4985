#include "common/evolution/evaluated.hpp"

#include <algorithm>

#include "common/check.hpp"
#include "common/evolution/population.hpp"
#include "common/evolution/selection.hpp"

namespace coppice {

Evaluated Evaluated::of(std::vector<Tree> trees, std::vector<Tally> tallies, const ScalarFitness& fitness) {
  COPPICE_CHECK(tallies.size() == trees.size());
  Evaluated result{std::move(trees), std::move(tallies), {}};
  result.fitness.reserve(result.trees.size());
  for (const Tally& tally : result.tallies) {
    result.fitness.push_back(fitness.of(tally));
  }
  return result;
}

std::size_t Evaluated::best() const { return ranking(trees, fitness).front(); }

Champion Evaluated::champion(std::size_t index, std::uint32_t generation) const {
  return {trees[index], generation, fitness[index], agreement_of(tallies[index])};
}

GenerationRecord statistics_of(std::span<const Seen> population, std::uint32_t generation) {
  COPPICE_CHECK(!population.empty());
  const Seen& best = *std::min_element(population.begin(), population.end(), [](const Seen& a, const Seen& b) {
    return a.fitness != b.fitness ? a.fitness > b.fitness : a.tree->size() < b.tree->size();
  });
  GenerationRecord record{.generation = generation,
                          .best = {*best.tree, generation, best.fitness, agreement_of(*best.tally)}};
  std::size_t measured = 0;
  std::vector<const Tree*> trees;
  trees.reserve(population.size());
  for (const Seen& individual : population) {
    trees.push_back(individual.tree);
    record.mean_nodes += static_cast<double>(individual.tree->size());
    if (individual.tally->steps > 0) {
      ++measured;
      record.mean_fitness += individual.fitness;
      record.mean_agreement += agreement_of(*individual.tally);
    }
  }
  record.mean_nodes /= static_cast<double>(population.size());
  record.mean_fitness /= static_cast<double>(std::max<std::size_t>(measured, 1));
  record.mean_agreement /= static_cast<double>(std::max<std::size_t>(measured, 1));
  record.distinct_trees = static_cast<std::uint32_t>(count_distinct(std::span<const Tree* const>(trees)));
  record.evaluations = population.size();
  return record;
}

GenerationRecord statistics_of(const Evaluated& population, std::uint32_t generation) {
  std::vector<Seen> seen;
  seen.reserve(population.trees.size());
  for (std::size_t slot = 0; slot < population.trees.size(); ++slot) {
    seen.push_back({&population.trees[slot], &population.tallies[slot], population.fitness[slot]});
  }
  return statistics_of(std::span<const Seen>(seen), generation);
}

}  // namespace coppice
