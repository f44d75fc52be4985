#include "common/evolution/config_keys.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <limits>
#include <type_traits>

#include "common/chain/exact.hpp"

namespace coppice {
namespace {

std::string describe(const ConfigValue& value) {
  return std::visit(
      [](const auto& v) -> std::string {
        using V = std::decay_t<decltype(v)>;
        if constexpr (std::is_same_v<V, std::string>) {
          return fmt::format("\"{}\"", v);
        } else if constexpr (std::is_same_v<V, OtherValue>) {
          return v.description;
        } else {
          return fmt::format("{}", v);
        }
      },
      value);
}

tl::unexpected<Error> mismatch(const ConfigKey& key, const ConfigValue& value, const std::string& expected) {
  return bad_input(fmt::format("{} is {}: expected {}", key.full_name(), describe(value), expected));
}

template <typename Integer>
Result<void> assign_integer(const ConfigKey& key, const ConfigValue& value, Integer& field) {
  constexpr bool kWide = std::is_same_v<Integer, std::uint64_t>;
  const auto expected = kWide ? fmt::format("an integer from 0 to {}", std::numeric_limits<std::uint64_t>::max())
                              : fmt::format("an integer from {:.0f} to {:.0f}", key.low, key.high);
  const auto within = [&](auto found) {
    if constexpr (kWide) {
      return found >= 0;
    } else {
      return static_cast<double>(found) >= key.low && static_cast<double>(found) <= key.high;
    }
  };
  if (const auto* narrow = std::get_if<std::int64_t>(&value); narrow != nullptr && within(*narrow)) {
    field = static_cast<Integer>(*narrow);
    return {};
  }
  if (const auto* wide = std::get_if<std::uint64_t>(&value); wide != nullptr && within(*wide)) {
    field = static_cast<Integer>(*wide);
    return {};
  }
  return mismatch(key, value, expected);
}

Result<void> assign_real(const ConfigKey& key, const ConfigValue& value, double& field) {
  double found = std::numeric_limits<double>::quiet_NaN();
  if (const auto* real = std::get_if<double>(&value)) {
    found = *real;
  } else if (const auto* narrow = std::get_if<std::int64_t>(&value)) {
    found = static_cast<double>(*narrow);
  } else if (const auto* wide = std::get_if<std::uint64_t>(&value)) {
    found = static_cast<double>(*wide);
  }
  if (!(found >= key.low && found <= key.high)) {
    return mismatch(key, value, fmt::format("a number from {} to {}", key.low, key.high));
  }
  field = found;
  return {};
}

// The values that a field of a named kind can have are 0 to kLastOf.
template <typename Named>
constexpr std::uint8_t kLastOf = 2;
template <>
constexpr std::uint8_t kLastOf<Method> = kMethods - 1;
template <>
constexpr std::uint8_t kLastOf<Prefer> = 5;
template <>
constexpr std::uint8_t kLastOf<Form> = 1;
template <>
constexpr std::uint8_t kLastOf<Search> = 1;
template <>
constexpr std::uint8_t kLastOf<Simplification> = 1;
template <>
constexpr std::uint8_t kLastOf<Migration> = 1;

template <typename Named>
Result<void> assign_named(const ConfigKey& key, const ConfigValue& value, Named& field) {
  const auto* text = std::get_if<std::string>(&value);
  std::string names;
  for (std::uint8_t i = 0; i <= kLastOf<Named>; ++i) {
    const Named named{i};
    if (text != nullptr && *text == name_of(named)) {
      field = named;
      return {};
    }
    names += fmt::format("{}\"{}\"", i == 0 ? "" : i == kLastOf<Named> ? " or " : ", ", name_of(named));
  }
  return mismatch(key, value, names);
}

Result<void> assign_text(const ConfigKey& key, const ConfigValue& value, std::string& field) {
  const auto* text = std::get_if<std::string>(&value);
  if (text == nullptr) {
    return mismatch(key, value, "text");
  }
  field = *text;
  return {};
}

Result<void> assign_measures(const ConfigKey& key, const ConfigValue& value, std::vector<Measure>& field) {
  const auto* text = std::get_if<std::string>(&value);
  if (text == nullptr) {
    return mismatch(key, value, "names with commas between, such as \"agreement, coverage, nodes\"");
  }
  auto measures = measures_from(*text);
  if (!measures) {
    return in_context(key.full_name(), measures.error());
  }
  field = std::move(*measures);
  return {};
}

}  // namespace

std::vector<ConfigKey> keys_of(EvolveConfig& config) {
  GaConfig& ga = config.ga;
  RolloutConfig& rollout = config.rollout;
  FitnessConfig& fitness = config.fitness;
  const auto weight = [](ObjectiveKind kind, double& field) {
    return ConfigKey{"fitness", std::string(name_of(kind)), &field, 0, kMaxWeight};
  };
  return {
      {"", "seed", &config.seed, 0, 0},
      {"ga", "generations", &ga.generations, 1, kMaxGenerations},
      {"ga", "population", &ga.population, 2, kMaxPopulation},
      {"ga", "tournament", &ga.tournament, 0, 1},
      {"ga", "crossover", &ga.crossover, 0, 1},
      {"ga", "mutation", &ga.mutation, 0, 1},
      {"ga", "headless_chicken", &ga.headless_chicken, 0, 1},
      {"ga", "max_depth", &ga.max_depth, 0, kMaxTreeDepth},
      {"ga", "max_children", &ga.max_children, 2, kMaxTreeNodes - 1},
      {"ga", "elites", &ga.elites, 0, kMaxPopulation - 1},
      {"ga", "max_nodes", &ga.max_nodes, 1, kMaxTreeNodes},
      {"ga", "max_conditions", &ga.max_conditions, 0, kMaxTreeNodes},
      {"ga", "form", &ga.form, 0, 0},
      {"ga", "search", &ga.search, 0, 0},
      {"ga", "simplify", &ga.simplify, 0, 0},
      {"ga", "seeding", &ga.seeding, 0, 0},
      {"ga", "edits", &ga.edits, 0, 1},
      {"ga", "local_search", &ga.local_search, 0, 1},
      {"ga", "guided", &ga.guided, 0, 1},
      {"ga", "guided_steps", &ga.guided_steps, 1, kMaxGuidedSteps},
      {"ga", "founders", &ga.founders, 0, 0},
      {"ga", "demes", &ga.demes, 1, kMaxDemes},
      {"ga", "epoch", &ga.epoch, 0, kMaxGenerations},
      {"ga", "migrants", &ga.migrants, 0, kMaxPopulation},
      {"ga", "migration", &ga.migration, 0, 0},
      {"rollout", "rollouts", &rollout.rollouts, 1, kMaxRollouts},
      {"rollout", "steps", &rollout.steps, 1, kMaxSteps},
      {"rollout", "final_rollouts", &rollout.final_rollouts, 1, kMaxRollouts},
      {"rollout", "acting", &rollout.acting, 0, 0},
      {"rollout", "policy_share", &rollout.policy_share, 0, 1},
      {"rollout", "schedule", &rollout.schedule, 0, 0},
      {"rollout", "policy_share_end", &rollout.policy_share_end, 0, 1},
      {"rollout", "start", &rollout.start, 0, 0},
      {"rollout", "method", &rollout.method, 0, 0},
      {"rollout", "final_method", &rollout.final_method, 0, 0},
      {"rollout", "gamma", &rollout.gamma, 0, kMaxGamma},
      weight(ObjectiveKind::agreement, fitness.agreement),
      weight(ObjectiveKind::q_value, fitness.q_value),
      weight(ObjectiveKind::shaped, fitness.shaped),
      weight(ObjectiveKind::coverage, fitness.coverage),
      weight(ObjectiveKind::visits, fitness.visits),
      weight(ObjectiveKind::expected_return, fitness.expected_return),
      weight(ObjectiveKind::regret, fitness.regret),
      weight(ObjectiveKind::seen, fitness.seen),
      weight(ObjectiveKind::collisions, fitness.collisions),
      weight(ObjectiveKind::unknown, fitness.unknown),
      {"fitness", "seen_visits", &fitness.seen_visits, 0, kMaxThreshold},
      {"fitness", "collision_reward", &fitness.collision_reward, -kMaxScoredValue, kMaxScoredValue},
      {"fitness", "size_threshold", &fitness.size_threshold, 0, 1},
      {"fitness", "size_nodes", &fitness.size_nodes, 1, kMaxTreeNodes},
      {"fitness", "size_weight", &fitness.size_weight, 0, kMaxWeight},
      {"front", "objectives", &config.front.objectives, 0, 0},
      {"front", "max_nodes", &config.front.max_nodes, 1, kMaxTreeNodes},
      {"front", "restarts", &config.front.restarts, 0, kMaxGenerations - 1},
      {"front", "members", &config.front.members, 1, kMaxPopulation},
      {"front", "pick", &config.front.pick, 0, 0},
      {"front", "prefer", &config.front.prefer, 0, 0},
  };
}

std::vector<ConfigKey> keys_of(RuleConfig& rule) {
  return {{"fitness.rule", "right", &rule.right, -kMaxRuleScore, kMaxRuleScore},
          {"fitness.rule", "wrong", &rule.wrong, -kMaxRuleScore, kMaxRuleScore}};
}

Result<void> assign(const ConfigKey& key, const ConfigValue& value) {
  return std::visit(
      [&](auto* field) -> Result<void> {
        using Field = std::decay_t<decltype(*field)>;
        if constexpr (std::is_same_v<Field, double>) {
          return assign_real(key, value, *field);
        } else if constexpr (std::is_same_v<Field, std::string>) {
          return assign_text(key, value, *field);
        } else if constexpr (std::is_same_v<Field, std::vector<Measure>>) {
          return assign_measures(key, value, *field);
        } else if constexpr (std::is_enum_v<Field>) {
          return assign_named(key, value, *field);
        } else {
          return assign_integer(key, value, *field);
        }
      },
      key.field);
}

ConfigValue value_of(const ConfigKey& key) {
  return std::visit(
      [](const auto* field) -> ConfigValue {
        using Field = std::decay_t<decltype(*field)>;
        if constexpr (std::is_same_v<Field, double> || std::is_same_v<Field, std::uint64_t> ||
                      std::is_same_v<Field, std::string>) {
          return *field;
        } else if constexpr (std::is_same_v<Field, std::vector<Measure>>) {
          return to_text(*field);
        } else if constexpr (std::is_enum_v<Field>) {
          return std::string(name_of(*field));
        } else {
          return std::int64_t{*field};
        }
      },
      key.field);
}

bool is_section(const std::vector<ConfigKey>& keys, std::string_view section) {
  return !section.empty() &&
         std::any_of(keys.begin(), keys.end(), [&](const ConfigKey& key) { return key.section == section; });
}

Result<const ConfigKey*> find_key(const std::vector<ConfigKey>& keys, std::string_view section, std::string_view name) {
  const auto found = std::find_if(keys.begin(), keys.end(),
                                  [&](const ConfigKey& key) { return key.section == section && key.name == name; });
  if (found != keys.end()) {
    return &*found;
  }
  std::vector<std::string> names;
  for (const ConfigKey& key : keys) {
    if (key.section == section) {
      names.push_back(key.name);
    } else if (section.empty() && std::find(names.begin(), names.end(), "[" + key.section + "]") == names.end()) {
      names.push_back("[" + key.section + "]");
    }
  }
  if (section == "fitness") {
    names.emplace_back("[[fitness.rule]]");
  } else if (section == "fitness.rule") {
    names.emplace_back(kAnyOfKey);
  }
  return bad_input(fmt::format("unknown key '{}'{}: expected one of {}", name,
                               section.empty() ? "" : fmt::format(" in [{}]", section), fmt::join(names, ", ")));
}

}  // namespace coppice
