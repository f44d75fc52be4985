// Generations of a deme: the first from nothing, every other from the one before. A slot is an individual's index among
// those of all demes. Chance in generation g is a pure function of (seed, g, deme), and of the slot in generation 0.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/evolution/breeding.hpp"
#include "common/evolution/config.hpp"
#include "common/tree/tree.hpp"

namespace coppice {

// Of generation 0, which begins with ga.founders, or of another with which a search begins anew. Grown trees; with
// ga.seeding every second one is seeded, as far as the limits allow. REQUIRES: check_search().
std::vector<Tree> first_population(const Breeding& breeding, const EvolveConfig& config, const Chain& chain,
                                   std::uint32_t generation = 0, std::uint32_t deme = 0);

// Individuals in one tournament: ga.tournament of those of all demes, so that demes do not make choosing blind; at most
// those that the deme has.
std::size_t tournament_size(const GaConfig& ga, std::uint32_t deme);

// What a mutation makes of a tree: a few edits, a grown subtree or a changed leaf, by the shares in `ga`.
Tree mutated(Stream& stream, const Breeding& breeding, const GaConfig& ga, const Tree& tree);

struct EvaluatedPopulation {
  std::span<const Tree> trees;      // by slot
  std::span<const double> fitness;  // by slot
};

// Generation `generation` >= 1 from the one before it: first the elites, unchanged; then the children of crossover, a
// share P_c of the rest; then copies of tournament winners. Everyone but the elites is then mutated with
// probability P_m. REQUIRES: parents.trees within the limits of `breeding`, as many as the deme has.
std::vector<Tree> next_population(const Breeding& breeding, const EvaluatedPopulation& parents, const GaConfig& ga,
                                  std::uint64_t seed, std::uint32_t generation, std::uint32_t deme = 0);

std::size_t count_distinct(std::span<const Tree> trees);
std::size_t count_distinct(std::span<const Tree* const> trees);

}  // namespace coppice
