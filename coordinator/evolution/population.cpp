#include "coordinator/evolution/population.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <unordered_set>

#include "common/check.hpp"
#include "coordinator/evolution/seeding.hpp"
#include "coordinator/evolution/selection.hpp"

namespace coppice {

std::vector<Tree> first_population(const Breeding& breeding, const EvolveConfig& config, const Chain& chain,
                                   std::uint32_t generation) {
  const GaConfig& ga = config.ga;
  const std::uint64_t seed = config.seed;
  std::vector<Tree> population;
  if (generation == 0) {
    auto founders = founders_of(ga, chain.vocabulary());
    COPPICE_CHECK(founders.has_value());  // check_config()
    population = std::move(*founders);
  }
  population.reserve(ga.population);
  for (auto slot = static_cast<std::uint32_t>(population.size()); slot < ga.population; ++slot) {
    Stream stream(seed, Purpose::growing, generation, slot);
    std::optional<Tree> seeded;
    if (slot % 2 == 1 && ga.seeding != Seeding::none) {
      seeded = seed_tree(ga.seeding, chain, ga.shape(), stream);
    }
    population.push_back(seeded && breeding.within_limits(*seeded) ? std::move(*seeded) : breeding.grow(stream));
  }
  return population;
}

Tree mutated(Stream& stream, const Breeding& breeding, const GaConfig& ga, const Tree& tree) {
  if (ga.edits > 0.0 && stream.chance(ga.edits)) {
    return breeding.edit(stream, tree);
  }
  return stream.chance(ga.headless_chicken) ? breeding.mutate_subtree(stream, tree)
                                            : breeding.mutate_leaf(stream, tree);
}

std::vector<Tree> next_population(const Breeding& breeding, const EvaluatedPopulation& parents, const GaConfig& ga,
                                  std::uint64_t seed, std::uint32_t generation) {
  COPPICE_CHECK(parents.trees.size() == ga.population && ga.elites < ga.population && generation >= 1);
  Stream stream(seed, Purpose::breeding, generation, 0);
  const std::vector<std::size_t> ranked = ranking(parents.trees, parents.fitness);
  const std::size_t size = tournament_size(ga.tournament, ga.population);
  const auto winner = [&]() -> const Tree& { return parents.trees[tournament(stream, parents.fitness, size)]; };

  std::vector<Tree> next;
  next.reserve(ga.population);
  for (std::size_t elite = 0; elite < ga.elites; ++elite) {
    next.push_back(parents.trees[ranked[elite]]);
  }
  const auto crossed =
      ga.elites + static_cast<std::size_t>(std::llround(ga.crossover * static_cast<double>(ga.population - ga.elites)));
  while (next.size() < crossed) {
    const Tree& mother = winner();
    const Tree& father = winner();
    auto [first, second] = breeding.crossover(stream, mother, father);
    next.push_back(std::move(first));
    if (next.size() < crossed) {
      next.push_back(std::move(second));
    }
  }
  while (next.size() < ga.population) {
    next.push_back(winner());
  }
  for (std::size_t slot = ga.elites; slot < next.size(); ++slot) {
    if (stream.chance(ga.mutation)) {
      next[slot] = mutated(stream, breeding, ga, next[slot]);
    }
  }
  if (ga.simplify == Simplification::lossless) {
    for (std::size_t slot = ga.elites; slot < next.size(); ++slot) {
      next[slot] = breeding.simplified(next[slot]);
    }
  }
  return next;
}

std::size_t count_distinct(std::span<const Tree> trees) {
  std::unordered_set<std::string> seen;
  for (const Tree& tree : trees) {
    std::string key;
    key.reserve(tree.size() * 6);
    for (const Node& node : tree.nodes()) {
      for (const unsigned part :
           {unsigned{static_cast<std::uint8_t>(node.kind)}, unsigned{static_cast<std::uint8_t>(node.op)},
            unsigned{node.index}, unsigned{node.value}, node.extent & 0xFFU, unsigned{node.extent} >> 8U}) {
        key.push_back(static_cast<char>(part));
      }
    }
    seen.insert(std::move(key));
  }
  return seen.size();
}

}  // namespace coppice
