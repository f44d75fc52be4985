#include "common/fitness/exact_evaluation.hpp"

#include <algorithm>
#include <cmath>

#include "common/check.hpp"

namespace coppice {

ExactEvaluation::ExactEvaluation(std::shared_ptr<const PreparedJob> job)
    : job_(std::move(job)), exact_(job_->chain().chain()) {
  COPPICE_CHECK(job_->job().method != Method::rollouts);
}

const Occupancy* ExactEvaluation::occupancy_of(std::span<const std::uint8_t> actions) {
  const Job& job = job_->job();
  if (policy_known_) {
    return of_policy_;
  }
  ActingTables acting{.actions = actions, .others = job_->chain().policy()};
  if (job.acting == Acting::policy) {
    acting.actions = job_->chain().policy();
  } else if (job.acting == Acting::mixed) {
    acting.others_share = fixed_point_value(job.policy_share);
  }
  const Occupancy* occupancy = nullptr;
  switch (job.method) {
    case Method::exact:
      occupancy = &exact_.over_steps(acting, job.steps);
      break;
    case Method::discounted:
      occupancy = exact_.discounted(acting, fixed_point_value(job.gamma));
      break;
    case Method::long_run:
      occupancy = exact_.long_run(acting);
      break;
    case Method::rollouts:
      COPPICE_CHECK(false);
  }
  policy_known_ = job.acting == Acting::policy;
  of_policy_ = occupancy;
  return occupancy;
}

void ExactEvaluation::score_walks(std::span<const std::uint8_t> actions, Tally& tally) {
  const Job& job = job_->job();
  const Occupancy* occupancy = occupancy_of(actions);
  if (occupancy == nullptr) {
    tally.steps = 0;
    return;
  }
  tally.steps = tally_steps(job);
  // Visits sum to `steps` or, as means per step, to 1; either way a power of two.
  const auto factor = static_cast<double>(job.method == Method::exact ? tally.steps / job.steps : tally.steps);
  const std::vector<std::uint8_t>& policy = job_->chain().policy();
  const bool has_terminals = !job_->chain().chain().parts().terminals.empty();
  double matches = 0.0;
  for (std::size_t i = 0; i < occupancy->states.size(); ++i) {
    const std::uint32_t state = occupancy->states[i];
    const bool agrees = actions[state] == policy[state] || (has_terminals && job_->chain().chain().is_terminal(state));
    matches += agrees ? occupancy->visits[i] : 0.0;
  }
  const auto rounded = static_cast<std::uint64_t>(std::llround(std::max(matches, 0.0) * factor));
  tally.matches = std::min(rounded, tally.steps);
  const std::size_t stride = job_->chain().chain().actions() + 1;
  for (std::size_t o = 0; o < tally.scores.size(); ++o) {
    const ObjectiveKind kind = job.objectives[o].kind;
    if (kind == ObjectiveKind::agreement) {
      tally.scores[o] = static_cast<std::int64_t>(tally.matches);
    } else if (along_walk(kind)) {
      const std::int64_t* scores = job_->tables()[o].scores.data();
      double sum = 0.0;
      for (std::size_t i = 0; i < occupancy->states.size(); ++i) {
        const std::uint32_t state = occupancy->states[i];
        sum += occupancy->visits[i] * static_cast<double>(scores[state * stride + actions[state]]);
      }
      tally.scores[o] = std::llround(sum * factor);
    }
  }
}

}  // namespace coppice
