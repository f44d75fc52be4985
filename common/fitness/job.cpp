#include "common/fitness/job.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>

#include "common/chain/exact.hpp"

namespace coppice {
namespace {

constexpr double kTwo64 = 18446744073709551616.0;

}  // namespace

std::uint64_t fixed_point_share(double value) {
  return value >= 1.0 ? ~std::uint64_t{0} : static_cast<std::uint64_t>(value * kTwo64);
}

double fixed_point_value(std::uint64_t share) { return static_cast<double>(share) / kTwo64; }

std::uint64_t tally_steps(const Job& job) {
  if (job.method == Method::rollouts) {
    return std::uint64_t{job.rollouts} * job.steps;
  }
  if (job.method != Method::exact) {
    return kMaxWalkedSteps;
  }
  std::uint64_t steps = job.steps;
  while (2 * steps <= kMaxWalkedSteps) {
    steps *= 2;
  }
  return steps;
}

Result<void> check_job(const Job& job) {
  if (job.objectives.empty() || job.objectives.size() > kMaxObjectives) {
    return bad_input(fmt::format("{} objectives: expected 1 to {}", job.objectives.size(), kMaxObjectives));
  }
  for (const Objective& objective : job.objectives) {
    if (objective.kind != ObjectiveKind::shaped && !objective.rules.empty()) {
      return bad_input(fmt::format("objective '{}' has rules: only 'shaped' may", name_of(objective.kind)));
    }
    const double threshold = objective.threshold;
    if (has_threshold(objective.kind) ? !(std::abs(threshold) <= kMaxThreshold) : threshold != 0.0) {
      return bad_input(fmt::format("objective '{}' has threshold {}: expected {}", name_of(objective.kind), threshold,
                                   has_threshold(objective.kind) ? "a finite number within +-2^53" : "0"));
    }
  }
  if (job.rollouts == 0 || job.rollouts > kMaxRollouts) {
    return bad_input(fmt::format("{} roll-outs: expected 1 to {}", job.rollouts, kMaxRollouts));
  }
  if (job.steps == 0 || job.steps > kMaxSteps) {
    return bad_input(fmt::format("{} steps: expected 1 to {}", job.steps, kMaxSteps));
  }
  if (std::uint64_t{job.rollouts} * job.steps > kMaxWalkedSteps) {
    return bad_input(fmt::format("{} roll-outs of {} steps: expected at most {} steps in all", job.rollouts, job.steps,
                                 kMaxWalkedSteps));
  }
  if (job.method != Method::rollouts && job.start != Start::initial) {
    return bad_input(fmt::format("start is '{}' of method '{}': only '{}' start elsewhere than in the initial state",
                                 name_of(job.start), name_of(job.method), name_of(Method::rollouts)));
  }
  if (job.method != Method::discounted && job.gamma != 0) {
    return bad_input(fmt::format("gamma is {} of method '{}': only 'discounted' has one", fixed_point_value(job.gamma),
                                 name_of(job.method)));
  }
  if (fixed_point_value(job.gamma) > kMaxGamma) {
    return bad_input(fmt::format("gamma is {}: expected 0 to {}", fixed_point_value(job.gamma), kMaxGamma));
  }
  return {};
}

Result<void> check_solvable(const Job& job, std::size_t states) {
  const bool solves = job.method == Method::discounted || job.method == Method::long_run;
  if (solves && states > kMaxSolvedStates) {
    return bad_input(fmt::format("method '{}' solves for at most {} states, the chain has {}: expected '{}' or '{}'",
                                 name_of(job.method), kMaxSolvedStates, states, name_of(Method::exact),
                                 name_of(Method::rollouts)));
  }
  return {};
}

}  // namespace coppice
