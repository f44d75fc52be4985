// What a front compares trees by, from their tallies: the costs, the fitness, and the measures that a user reads.
// Immutable; the same tally gives the same bits everywhere.
#pragma once

#include <span>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/error.hpp"
#include "common/evolution/config.hpp"
#include "common/evolution/deme.hpp"
#include "common/evolution/front_individual.hpp"
#include "common/evolution/measure.hpp"
#include "common/evolution/scalar_fitness.hpp"

namespace coppice {

class FrontGauge {
 public:
  // Errors: as objectives_of() and make_score_table(). REQUIRES: config.ga.search is front.
  static Result<FrontGauge> make(const Chain& chain, const EvolveConfig& config);

  // What has to be in the job, in this order.
  const std::vector<Objective>& objectives() const { return fitness_.objectives(); }

  // All but its meaning. REQUIRES: the tally has a score for every objective.
  FrontIndividual of(Individual individual) const;

  const std::vector<Measure>& measures() const { return measuring_.measures(); }
  // [measures] REQUIRES: tally.steps > 0.
  std::vector<double> values(const Tree& tree, const Tally& tally) const { return measuring_.values(tree, tally); }

  // What 1 more in each objective is worth (GuidedClimb::climb), if 1 more in each cost is worth -weights[cost]; sizes
  // are worth nothing. [objectives]
  std::vector<double> worth(std::span<const double> weights) const;

 private:
  FrontGauge(ScalarFitness fitness, Measuring measuring, const std::vector<Measure>& front);

  ScalarFitness fitness_;
  Measuring measuring_;
  struct Compared {
    std::size_t measure = 0;  // index into measures()
    double sign = 1.0;        // that makes a cost of it
  };
  std::vector<Compared> compared_;  // [front.objectives]
};

}  // namespace coppice
