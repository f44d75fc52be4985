// One number for an individual, from its tally:
//
//   fitness = sum over objectives of weight x normalised score  +  size_weight x size term     [dimensionless]
//
// A normalised score is 1 for the best that the objective's table allows: score / (best_per_step x steps) along walks,
// score / best over states; where nothing scores above 0 it is the objective's mean value instead (at best 0). Costs
// (regret, collisions, unknown) count against it: their score / worst is taken off. The size term (thesis VI-E.3) is 0
// until agreement along the walk exceeds size_threshold, then min(1, size_nodes / nodes). Immutable; the same tally
// gives the same bits everywhere.
#pragma once

#include <span>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/error.hpp"
#include "common/evolution/config.hpp"
#include "common/fitness/job.hpp"

namespace coppice {

// matches / steps, 0 for an individual that gave no result (no steps).
double agreement_of(const Tally& tally);

class ScalarFitness {
 public:
  // Fitness of an individual that could not be evaluated (a tally without steps): below every other, and left out of
  // means.
  static constexpr double kNone = -1e300;

  // `also` is asked for beside the objectives of weight above 0, and changes no fitness.
  // Errors: as objectives_of() and make_score_table().
  static Result<ScalarFitness> make(const Chain& chain, const FitnessConfig& fitness,
                                    std::span<const Measure> also = {});

  // What has to be in the job, in this order.
  const std::vector<Objective>& objectives() const { return objectives_; }

  // REQUIRES: tally.scores has one entry per objective.
  double of(const Tally& tally) const;

 private:
  ScalarFitness(const FitnessConfig& fitness, std::vector<Objective> objectives)
      : fitness_(fitness), objectives_(std::move(objectives)) {}

  FitnessConfig fitness_;
  std::vector<Objective> objectives_;
  std::vector<double> best_;  // [objectives], the score that counts as 1; a step along walks
};

}  // namespace coppice
