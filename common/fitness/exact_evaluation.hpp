// Scores along the walk without walking: expected values, in the shape of a tally. What the methods give, for a job of
// t steps and for all objectives along the walk (those over states need no walk and stay as they are):
//
//   exact       steps = t x scale, with scale the largest power of two for which that is within kMaxWalkedSteps;
//               matches and scores are the expected sums over t steps, times scale, rounded to the nearest
//   discounted  steps = kMaxWalkedSteps; means per step, step i weighted by (1 - gamma) gamma^i, times steps, rounded
//   long_run    the same with the mean over infinitely many steps
//
// so a tally reads as if that many steps had been walked without noise, and its rounding is below that of one step in
// 2^23. A tally of 0 steps means that the tree could not be solved (ExactOccupancy names the limits).
//
// Nothing here depends on chance. Scratch memory of one thread.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "common/chain/exact.hpp"
#include "common/fitness/prepared_job.hpp"

namespace coppice {

class ExactEvaluation {
 public:
  // REQUIRES: job->job().method is not rollouts.
  explicit ExactEvaluation(std::shared_ptr<const PreparedJob> job);

  // Sets steps, matches and the scores along the walk. REQUIRES: tally.scores has one entry per objective, all 0.
  void score_walks(std::span<const std::uint8_t> actions, Tally& tally);

 private:
  const Occupancy* occupancy_of(std::span<const std::uint8_t> actions);

  std::shared_ptr<const PreparedJob> job_;
  ExactOccupancy exact_;
  bool policy_known_ = false;  // acting policy: one occupancy serves all trees
  const Occupancy* of_policy_ = nullptr;
};

}  // namespace coppice
