#include "coordinator/evolution/config.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "common/check.hpp"
#include "common/tree/text.hpp"

namespace coppice {
namespace {

Result<ShapedRule> rule_of(const RuleConfig& rule, const Vocabulary& vocabulary) {
  if (rule.any_of.size() > kMaxShapedConditions) {
    return bad_input(fmt::format("{} conditions: expected at most {}", rule.any_of.size(), kMaxShapedConditions));
  }
  ShapedRule result{{}, rule.right, rule.wrong};
  for (const std::string& text : rule.any_of) {
    const auto tree = parse_tree(text, vocabulary);
    if (!tree) {
      return in_context(fmt::format("'{}'", text), tree.error());
    }
    if ((*tree)[0].kind != NodeKind::condition) {
      return bad_input(fmt::format("'{}' is not a condition: expected one such as '{}={}'", text,
                                   vocabulary.features.front().name, vocabulary.features.front().values.front()));
    }
    result.any_of.push_back((*tree)[0]);
  }
  return result;
}

Result<void> check_walk(const char* key, std::uint32_t rollouts, std::uint32_t steps) {
  if (std::uint64_t{rollouts} * steps > kMaxWalkedSteps) {
    return bad_input(fmt::format("rollout.{} is {} of {} steps each: expected at most {} steps in all", key, rollouts,
                                 steps, kMaxWalkedSteps));
  }
  return {};
}

}  // namespace

double FitnessConfig::weight(ObjectiveKind kind) const {
  switch (kind) {
    case ObjectiveKind::agreement:
      return agreement;
    case ObjectiveKind::q_value:
      return q_value;
    case ObjectiveKind::shaped:
      return shaped;
    case ObjectiveKind::coverage:
      return coverage;
    case ObjectiveKind::visits:
      return visits;
    case ObjectiveKind::expected_return:
      return expected_return;
  }
  COPPICE_CHECK(false);
}

Result<void> check_config(const EvolveConfig& config, const Vocabulary& vocabulary) {
  if (config.ga.elites >= config.ga.population) {
    return bad_input(fmt::format("ga.elites is {}: expected fewer than ga.population, which is {}", config.ga.elites,
                                 config.ga.population));
  }
  const RolloutConfig& rollout = config.rollout;
  if (rollout.method == Method::rollouts) {
    if (auto ok = check_walk("rollouts", rollout.rollouts, rollout.steps); !ok) {
      return ok;
    }
    if (auto ok = check_walk("final_rollouts", rollout.final_rollouts, rollout.steps); !ok) {
      return ok;
    }
  }
  const auto objectives = objectives_of(config.fitness, vocabulary);
  return objectives ? Result<void>() : tl::unexpected(objectives.error());
}

Result<std::vector<Objective>> objectives_of(const FitnessConfig& fitness, const Vocabulary& vocabulary) {
  std::vector<ShapedRule> rules;
  if (fitness.rules.size() > kMaxShapedRules) {
    return bad_input(fmt::format("fitness.rule: {} rules: expected at most {}", fitness.rules.size(), kMaxShapedRules));
  }
  for (std::size_t i = 0; i < fitness.rules.size(); ++i) {
    auto rule = rule_of(fitness.rules[i], vocabulary);
    if (!rule) {
      return in_context(fmt::format("fitness.rule {}", i + 1), rule.error());
    }
    rules.push_back(std::move(*rule));
  }
  std::vector<Objective> objectives;
  for (std::uint8_t k = 0; k < kObjectiveKinds; ++k) {
    const ObjectiveKind kind{k};
    if (fitness.weight(kind) > 0.0) {
      objectives.push_back({kind, {}});
    }
    if (fitness.weight(kind) > 0.0 && kind == ObjectiveKind::shaped) {
      if (rules.empty()) {
        auto defaults = thesis_rules(vocabulary);
        if (!defaults) {
          return in_context("fitness.shaped", defaults.error());
        }
        rules = std::move(*defaults);
      }
      objectives.back().rules = rules;
    }
  }
  if (objectives.empty()) {
    return bad_input("fitness: every weight is 0: expected one objective or more with a weight above 0");
  }
  return objectives;
}

Job job_of(const EvolveConfig& config, std::vector<Objective> objectives, std::uint32_t generation) {
  const RolloutConfig& rollout = config.rollout;
  Job job;
  job.objectives = std::move(objectives);
  if (rollout.method == Method::rollouts) {
    job.rollouts = generation == kFinalGeneration ? rollout.final_rollouts : rollout.rollouts;
    job.seed = config.seed;
    job.generation = generation;
  } else {
    job.rollouts = 1;  // nothing is drawn: one job for all generations, so what is known of a tree stays known
  }
  job.steps = rollout.steps;
  job.acting = rollout.acting;
  job.policy_share = rollout.acting == Acting::mixed ? fixed_point_share(rollout.policy_share) : 0;
  job.method = rollout.method;
  job.gamma = rollout.method == Method::discounted ? fixed_point_share(rollout.gamma) : 0;
  return job;
}

}  // namespace coppice
