// Individuals that were asked for together, and what came back.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/evolution/champion.hpp"
#include "common/evolution/scalar_fitness.hpp"
#include "common/fitness/job.hpp"
#include "common/tree/tree.hpp"

namespace coppice {

struct Evaluated {
  std::vector<Tree> trees;
  std::vector<Tally> tallies;   // [trees]
  std::vector<double> fitness;  // [trees], scalar

  // REQUIRES: one tally per tree, each with a score for every objective of `fitness`.
  static Evaluated of(std::vector<Tree> trees, std::vector<Tally> tallies, const ScalarFitness& fitness);

  // The index of the highest fitness; ties: fewer nodes, then earlier. REQUIRES: there are trees.
  std::size_t best() const;
  Champion champion(std::size_t index, std::uint32_t generation) const;
};

// An individual as statistics look at it; it stays where it is.
struct Seen {
  const Tree* tree = nullptr;
  const Tally* tally = nullptr;
  double fitness = 0.0;
};

// A generation's row of the statistics, all but `seconds`. REQUIRES: there are individuals.
GenerationRecord statistics_of(std::span<const Seen> population, std::uint32_t generation);
GenerationRecord statistics_of(const Evaluated& population, std::uint32_t generation);

}  // namespace coppice
