#include "common/evolution/population.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string_view>
#include <type_traits>
#include <unordered_set>

#include "common/check.hpp"
#include "common/evolution/migration.hpp"
#include "common/evolution/seeding.hpp"
#include "common/evolution/selection.hpp"

namespace coppice {

std::vector<Tree> first_population(const Breeding& breeding, const EvolveConfig& config, const Chain& chain,
                                   std::uint32_t generation, std::uint32_t deme) {
  const GaConfig& ga = config.ga;
  const DemeShare share = share_of(ga, deme);
  const std::uint64_t seed = config.seed;
  std::vector<Tree> population;
  if (generation == 0) {
    auto founders = founders_of(ga, chain.vocabulary());
    COPPICE_CHECK(founders.has_value());  // check_search()
    for (std::size_t i = deme; i < founders->size(); i += ga.demes) {
      population.push_back(std::move((*founders)[i]));
    }
  }
  population.reserve(share.size);
  for (auto slot = static_cast<std::uint32_t>(population.size()); slot < share.size; ++slot) {
    Stream stream(seed, Purpose::growing, generation, share.first + slot);
    std::optional<Tree> seeded;
    if (slot % 2 == 1 && ga.seeding != Seeding::none) {
      seeded = seed_tree(ga.seeding, chain, ga.shape(), stream);
    }
    population.push_back(seeded && breeding.within_limits(*seeded) ? std::move(*seeded) : breeding.grow(stream));
  }
  return population;
}

std::size_t tournament_size(const GaConfig& ga, std::uint32_t deme) {
  return std::min<std::size_t>(tournament_size(ga.tournament, ga.population), share_of(ga, deme).size);
}

Tree mutated(Stream& stream, const Breeding& breeding, const GaConfig& ga, const Tree& tree) {
  if (ga.edits > 0.0 && stream.chance(ga.edits)) {
    return breeding.edit(stream, tree);
  }
  return stream.chance(ga.headless_chicken) ? breeding.mutate_subtree(stream, tree)
                                            : breeding.mutate_leaf(stream, tree);
}

std::vector<Tree> next_population(const Breeding& breeding, const EvaluatedPopulation& parents, const GaConfig& ga,
                                  std::uint64_t seed, std::uint32_t generation, std::uint32_t deme) {
  const std::size_t individuals = share_of(ga, deme).size;
  COPPICE_CHECK(parents.trees.size() == individuals && ga.elites < individuals && generation >= 1);
  Stream stream(seed, Purpose::breeding, generation, deme);
  const std::vector<std::size_t> ranked = ranking(parents.trees, parents.fitness);
  const std::size_t size = tournament_size(ga, deme);
  const auto winner = [&]() -> const Tree& { return parents.trees[tournament(stream, parents.fitness, size)]; };

  std::vector<Tree> next;
  next.reserve(individuals);
  for (std::size_t elite = 0; elite < ga.elites; ++elite) {
    next.push_back(parents.trees[ranked[elite]]);
  }
  const auto crossed =
      ga.elites + static_cast<std::size_t>(std::llround(ga.crossover * static_cast<double>(individuals - ga.elites)));
  while (next.size() < crossed) {
    const Tree& mother = winner();
    const Tree& father = winner();
    auto [first, second] = breeding.crossover(stream, mother, father);
    next.push_back(std::move(first));
    if (next.size() < crossed) {
      next.push_back(std::move(second));
    }
  }
  while (next.size() < individuals) {
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

std::size_t count_distinct(std::span<const Tree* const> trees) {
  static_assert(std::has_unique_object_representations_v<Node>, "equal nodes are equal bytes");
  std::unordered_set<std::string_view> seen;
  seen.reserve(trees.size());
  for (const Tree* const tree : trees) {
    const std::span<const std::byte> bytes = std::as_bytes(tree->nodes());
    seen.emplace(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  }
  return seen.size();
}

std::size_t count_distinct(std::span<const Tree> trees) {
  std::vector<const Tree*> pointers;
  pointers.reserve(trees.size());
  for (const Tree& tree : trees) {
    pointers.push_back(&tree);
  }
  return count_distinct(std::span<const Tree* const>(pointers));
}

}  // namespace coppice
