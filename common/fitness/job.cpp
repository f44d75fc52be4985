#include "common/fitness/job.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>

namespace coppice {
namespace {

constexpr std::array<std::string_view, 3> kActingNames = {"tree", "policy", "mixed"};

}  // namespace

std::string_view name_of(Acting acting) { return kActingNames.at(static_cast<std::size_t>(acting)); }

Result<Acting> acting_named(std::string_view name) {
  const auto found = std::find(kActingNames.begin(), kActingNames.end(), name);
  if (found == kActingNames.end()) {
    return bad_input(fmt::format("no acting policy '{}': expected one of {}", name, fmt::join(kActingNames, ", ")));
  }
  return static_cast<Acting>(found - kActingNames.begin());
}

Result<void> check_job(const Job& job) {
  if (job.objectives.empty() || job.objectives.size() > kMaxObjectives) {
    return bad_input(fmt::format("{} objectives: expected 1 to {}", job.objectives.size(), kMaxObjectives));
  }
  for (const Objective& objective : job.objectives) {
    if (objective.kind != ObjectiveKind::shaped && !objective.rules.empty()) {
      return bad_input(fmt::format("objective '{}' has rules: only 'shaped' may", name_of(objective.kind)));
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
  return {};
}

}  // namespace coppice
