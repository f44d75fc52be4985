#include "common/evolution/config.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>

#include "common/check.hpp"
#include "common/evolution/seeding.hpp"
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

// Every deme has two individuals or more, and room for its elites and for migrants.
Result<void> check_demes(const GaConfig& ga) {
  const std::uint32_t smallest = ga.population / ga.demes;
  const std::string deme = ga.demes == 1
                               ? fmt::format("ga.population, which is {}", ga.population)
                               : fmt::format("the smallest of the ga.demes, {} of {} individuals, which has {}",
                                             ga.demes, ga.population, smallest);
  if (smallest < 2) {
    return bad_input(
        fmt::format("ga.demes is {}: expected at most half of ga.population, which is {}", ga.demes, ga.population));
  }
  if (ga.elites >= smallest) {
    return bad_input(fmt::format("ga.elites is {}: expected fewer than {}", ga.elites, deme));
  }
  if (ga.demes > 1 && ga.migrants >= smallest - ga.elites) {
    return bad_input(fmt::format("ga.migrants is {}: with {} elites expected fewer than are left of {}", ga.migrants,
                                 ga.elites, deme));
  }
  return {};
}

// Of a mixed acting policy. The last generation's share also holds for the final sample.
double policy_share_in(const EvolveConfig& config, std::uint32_t generation) {
  const RolloutConfig& rollout = config.rollout;
  const std::uint32_t last = config.ga.generations - 1;
  const std::uint32_t at = std::min(generation, last);
  switch (rollout.schedule) {
    case Schedule::linear:
      return last == 0 ? rollout.policy_share_end
                       : rollout.policy_share + (rollout.policy_share_end - rollout.policy_share) * at / last;
    case Schedule::step:
      return at < config.ga.generations / 2 ? rollout.policy_share : rollout.policy_share_end;
    case Schedule::constant:
      break;
  }
  return rollout.policy_share;
}

}  // namespace

std::vector<Measure> front_objectives() {
  return {measure_of(ObjectiveKind::agreement), measure_of(ObjectiveKind::coverage),
          measure_of(ObjectiveKind::expected_return), measure_of(ObjectiveKind::collisions), kNodesMeasure};
}

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
    case ObjectiveKind::regret:
      return regret;
    case ObjectiveKind::seen:
      return seen;
    case ObjectiveKind::collisions:
      return collisions;
    case ObjectiveKind::unknown:
      return unknown;
  }
  COPPICE_CHECK(false);
}

Result<void> check_search(const EvolveConfig& config, const Vocabulary& vocabulary) {
  if (auto ok = check_demes(config.ga); !ok) {
    return ok;
  }
  const auto founders = founders_of(config.ga, vocabulary);
  if (!founders) {
    return in_context("ga.founders", founders.error());
  }
  if (config.ga.guided > 0.0 && config.ga.search != Search::front) {
    return bad_input(fmt::format("ga.guided is {}: expected 0 where ga.search is not \"front\"", config.ga.guided));
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
  if (rollout.final_method != Method::rollouts &&
      (rollout.final_method != Method::exact || rollout.method != Method::rollouts)) {
    return bad_input(
        fmt::format("rollout.final_method is \"{}\" with rollout.method \"{}\": expected \"rollouts\", or \"exact\" "
                    "after roll-outs",
                    name_of(rollout.final_method), name_of(rollout.method)));
  }
  if (rollout.schedule != Schedule::constant && rollout.acting != Acting::mixed) {
    return bad_input(
        fmt::format("rollout.schedule is \"{}\" with rollout.acting \"{}\": only a mixed acting policy has "
                    "a share that can change",
                    name_of(rollout.schedule), name_of(rollout.acting)));
  }
  for (const auto& [key, method] :
       {std::pair{"method", rollout.method}, std::pair{"final_method", rollout.final_method}}) {
    if (rollout.start != Start::initial && method != Method::rollouts) {
      return bad_input(
          fmt::format("rollout.start is \"{}\" with rollout.{} \"{}\": only roll-outs start elsewhere than "
                      "in the initial state",
                      name_of(rollout.start), key, name_of(method)));
    }
  }
  if (config.ga.search == Search::front && rollout.schedule != Schedule::constant) {
    return bad_input(
        "rollout.schedule changes what a generation measures: expected \"constant\" where ga.search is "
        "\"front\", which compares trees of different generations");
  }
  if (config.ga.search == Search::front && config.front.restarts >= config.ga.generations) {
    return bad_input(fmt::format("front.restarts is {}: expected fewer than ga.generations, which is {}",
                                 config.front.restarts, config.ga.generations));
  }
  const auto objectives = objectives_of(config, vocabulary);
  return objectives ? Result<void>() : tl::unexpected(objectives.error());
}

Result<std::vector<Objective>> objectives_of(const EvolveConfig& config, const Vocabulary& vocabulary) {
  if (config.ga.search == Search::front) {
    return objectives_of(config.fitness, vocabulary, config.front.objectives);
  }
  return objectives_of(config.fitness, vocabulary);
}

Result<std::vector<Objective>> objectives_of(const FitnessConfig& fitness, const Vocabulary& vocabulary,
                                             std::span<const Measure> also) {
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
    const bool wanted =
        fitness.weight(kind) > 0.0 || std::find(also.begin(), also.end(), measure_of(kind)) != also.end();
    if (wanted) {
      objectives.push_back({kind});
      objectives.back().threshold = kind == ObjectiveKind::seen         ? fitness.seen_visits
                                    : kind == ObjectiveKind::collisions ? fitness.collision_reward
                                                                        : 0.0;
    }
    if (wanted && kind == ObjectiveKind::shaped) {
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
  const bool last = generation == kFinalGeneration;
  job.method = last && rollout.method == Method::rollouts ? rollout.final_method : rollout.method;
  if (job.method == Method::rollouts) {
    job.rollouts = last ? rollout.final_rollouts : rollout.rollouts;
    job.seed = config.seed;
    job.generation = generation;
  } else {
    job.rollouts = 1;  // nothing is drawn: one job for all generations, so what is known of a tree stays known
  }
  job.steps = rollout.steps;
  job.acting = rollout.acting;
  job.policy_share = rollout.acting == Acting::mixed ? fixed_point_share(policy_share_in(config, generation)) : 0;
  job.start = rollout.start;
  job.gamma = job.method == Method::discounted ? fixed_point_share(rollout.gamma) : 0;
  return job;
}

}  // namespace coppice
