// Individuals that were asked for together, and what came back.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/error.hpp"
#include "common/fitness/job.hpp"
#include "common/tree/tree.hpp"
#include "coordinator/dispatch/evaluator.hpp"
#include "coordinator/evolution/evolve.hpp"
#include "coordinator/evolution/scalar_fitness.hpp"

namespace coppice {

struct Evaluated {
  std::vector<Tree> trees;
  std::vector<Tally> tallies;   // [trees]
  std::vector<double> fitness;  // [trees], scalar

  // The index of the highest fitness; ties: fewer nodes, then earlier. REQUIRES: there are trees.
  std::size_t best() const;
  Champion champion(std::size_t index, std::uint32_t generation) const;
};

// With the random numbers of `generation`. Errors: those of the evaluator.
Result<Evaluated> evaluate(std::vector<Tree> trees, std::uint32_t generation, const EvolveConfig& config,
                           const ScalarFitness& fitness, Evaluator& evaluator);

// A generation's row of the statistics, all but `seconds`. REQUIRES: there are trees.
GenerationRecord statistics_of(const Evaluated& population, std::uint32_t generation);

}  // namespace coppice
