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

template <Named Enumeration>
Result<void> assign_named(const ConfigKey& key, const ConfigValue& value, Enumeration& field) {
  const auto* text = std::get_if<std::string>(&value);
  constexpr auto kAll = kNames<Enumeration>;
  std::string expected;
  for (std::size_t i = 0; i < kAll.size(); ++i) {
    if (text != nullptr && *text == kAll[i]) {
      field = static_cast<Enumeration>(i);
      return {};
    }
    expected += fmt::format("{}\"{}\"", i == 0 ? "" : i + 1 == kAll.size() ? " or " : ", ", kAll[i]);
  }
  return mismatch(key, value, expected);
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
  const auto weight = [](ObjectiveKind kind, double& field, const char* help) {
    return ConfigKey{"fitness", std::string(name_of(kind)), &field, 0, kMaxWeight, help};
  };
  return {
      {"", "seed", &config.seed, 0, 0, "the same seed gives the same trees, bit for bit"},
      {"ga", "generations", &ga.generations, 1, kMaxGenerations, "G of the thesis"},
      {"ga", "population", &ga.population, 2, kMaxPopulation, "M of the thesis: individuals, in all demes together"},
      {"ga", "tournament", &ga.tournament, 0, 1,
       "s of the thesis: share of the population in a tournament; at least one individual"},
      {"ga", "crossover", &ga.crossover, 0, 1, "P_c of the thesis: share of a generation that crossover makes"},
      {"ga", "mutation", &ga.mutation, 0, 1, "P_m of the thesis: probability that a child is mutated"},
      {"ga", "headless_chicken", &ga.headless_chicken, 0, 1,
       "P_hcc of the thesis: probability that a mutation is a macro mutation"},
      {"ga", "max_depth", &ga.max_depth, 0, kMaxTreeDepth, "D_d of the thesis: edges from the root"},
      {"ga", "max_children", &ga.max_children, 2, kMaxTreeNodes - 1, "D_c of the thesis: children of a node"},
      {"ga", "elites", &ga.elites, 0, kMaxPopulation - 1,
       "individuals that pass unchanged, fewer than the population; not in the thesis"},
      {"ga", "max_nodes", &ga.max_nodes, 1, kMaxTreeNodes, "most nodes of a child"},
      {"ga", "max_conditions", &ga.max_conditions, 0, kMaxTreeNodes,
       "most conditions of a child: what a decision tree has as tests"},
      {"ga", "form", &ga.form, 0, 0, "\"free\": any tree; \"guarded\": only trees that ask before they act"},
      {"ga", "search", &ga.search, 0, 0,
       "\"scalar\": one number decides; \"front\": no tree is dropped that none other beats in every measure"},
      {"ga", "simplify", &ga.simplify, 0, 0,
       "of every child: \"none\", or \"lossless\", pruning that holds in every possible state"},
      {"ga", "seeding", &ga.seeding, 0, 0,
       "every second tree of the first generation: \"none\" (grown like the others), \"branches\" (a selector of "
       "single-condition branches), or \"greedy\" (a decision list grown from the policy)"},
      {"ga", "edits", &ga.edits, 0, 1,
       "share of the mutations that are a few small edits: leaves changed, put in, taken out, moved"},
      {"ga", "local_search", &ga.local_search, 0, 1,
       "search = \"front\": share of the children that are edits of good trees"},
      {"ga", "guided", &ga.guided, 0, 1,
       "search = \"front\": share of the children that then climb by guided edits, which are ranked by what they gain "
       "to first order and solved exactly, as far as they lead"},
      {"ga", "guided_steps", &ga.guided_steps, 1, kMaxGuidedSteps, "edits that one of them may climb"},
      {"ga", "founders", &ga.founders, 0, 0,
       "trees that the first generation begins with, as text with ; between; at most a population"},
      {"ga", "demes", &ga.demes, 1, kMaxDemes,
       "populations of their own that share the individuals of ga.population; the run is spread over threads or "
       "workers by demes, and is the same for any number of those"},
      {"ga", "epoch", &ga.epoch, 0, kMaxGenerations,
       "demes > 1: generations between two exchanges of individuals; 0: none until the end"},
      {"ga", "migrants", &ga.migrants, 0, kMaxPopulation,
       "demes > 1: individuals that a deme is given when an epoch begins"},
      {"ga", "migration", &ga.migration, 0, 0,
       "demes > 1: from whom, its neighbour in a \"ring\", or in a \"random\" one, drawn for each epoch"},
      {"rollout", "rollouts", &rollout.rollouts, 1, kMaxRollouts,
       "k of the thesis: walks per individual in a generation"},
      {"rollout", "steps", &rollout.steps, 1, kMaxSteps, "t of the thesis: steps per walk"},
      {"rollout", "final_rollouts", &rollout.final_rollouts, 1, kMaxRollouts,
       "walks per champion when the best of all generations is chosen; not in the thesis"},
      {"rollout", "acting", &rollout.acting, 0, 0, "who chooses the transitions: \"tree\", \"policy\" or \"mixed\""},
      {"rollout", "policy_share", &rollout.policy_share, 0, 1,
       "acting = \"mixed\": probability, in each step, that the policy chooses"},
      {"rollout", "schedule", &rollout.schedule, 0, 0,
       "acting = \"mixed\": how policy_share becomes policy_share_end over the generations: \"constant\" (never), "
       "\"linear\", or \"step\" (halfway)"},
      {"rollout", "policy_share_end", &rollout.policy_share_end, 0, 1, "see schedule"},
      {"rollout", "start", &rollout.start, 0, 0,
       "where walks start: \"initial\" state, \"visits\" (as often as visited in learning), or \"uniform\""},
      {"rollout", "method", &rollout.method, 0, 0,
       "\"rollouts\" samples walks; the others compute expected values, without chance: \"exact\" over `steps` steps, "
       "\"discounted\" with step i weighing gamma^i, \"long_run\" over infinitely many"},
      {"rollout", "final_method", &rollout.final_method, 0, 0,
       "of the last comparison: \"rollouts\", final_rollouts of them, or \"exact\""},
      {"rollout", "gamma", &rollout.gamma, 0, kMaxGamma, "method = \"discounted\": the discount factor"},
      weight(ObjectiveKind::agreement, fitness.agreement,
             "weight of: the tree's action is the policy's, along the walk"),
      weight(ObjectiveKind::q_value, fitness.q_value, "weight of: Q(s, tree's action), along the walk"),
      weight(ObjectiveKind::shaped, fitness.shaped,
             "weight of: rules by predicate, along the walk, see [[fitness.rule]]"),
      weight(ObjectiveKind::coverage, fitness.coverage, "weight of: states in which tree and policy agree"),
      weight(ObjectiveKind::visits, fitness.visits,
             "weight of: the same, each state as often as it was visited in learning"),
      weight(ObjectiveKind::expected_return, fitness.expected_return,
             "weight of: mean reward recorded for the tree's action, along the walk"),
      weight(ObjectiveKind::regret, fitness.regret,
             "weight of a cost: what the tree's actions lose against the best by Q, each state by its visits"),
      weight(ObjectiveKind::seen, fitness.seen,
             "weight of: states visited seen_visits times or more in which tree and policy agree"),
      weight(ObjectiveKind::collisions, fitness.collisions,
             "weight of a cost: steps of the walk that are collisions, as the chain counts them, else those whose "
             "recorded mean reward is collision_reward or less"),
      weight(ObjectiveKind::unknown, fitness.unknown,
             "weight of a cost: steps of the walk in a (state, action) that was never tried"),
      {"fitness", "seen_visits", &fitness.seen_visits, 0, kMaxThreshold, "see seen"},
      {"fitness", "collision_reward", &fitness.collision_reward, -kMaxScoredValue, kMaxScoredValue, "see collisions"},
      {"fitness", "size_threshold", &fitness.size_threshold, 0, 1, "once agreement exceeds this, ..."},
      {"fitness", "size_nodes", &fitness.size_nodes, 1, kMaxTreeNodes, "... min(1, size_nodes / nodes) is added, ..."},
      {"fitness", "size_weight", &fitness.size_weight, 0, kMaxWeight, "... times this"},
      {"front", "objectives", &config.front.objectives, 0, 0,
       "what trees are compared by: names of weights, and nodes"},
      {"front", "max_nodes", &config.front.max_nodes, 1, kMaxTreeNodes, "most nodes of a tree that is kept"},
      {"front", "restarts", &config.front.restarts, 0, kMaxGenerations - 1,
       "times that the search begins anew; its last part goes on from what all parts kept"},
      {"front", "members", &config.front.members, 1, kMaxPopulation, "trees kept; the most crowded go first"},
      {"front", "pick", &config.front.pick, 0, 0,
       "which is the answer, as \"best return with nodes<=20 and coverage>=0.8\" (coppice help pick)"},
      {"front", "prefer", &config.front.prefer, 0, 0,
       "who chooses: \"pick\", the rule above, on the chain; or what trees of the front are worth in the simulator, if "
       "the study has one, by \"balance\", \"return\", \"agreement\", \"coverage\" or \"size\""},
  };
}

std::vector<ConfigKey> keys_of(RuleConfig& rule) {
  return {{"fitness.rule", "right", &rule.right, -kMaxRuleScore, kMaxRuleScore,
           "score where the tree's action is the policy's"},
          {"fitness.rule", "wrong", &rule.wrong, -kMaxRuleScore, kMaxRuleScore, "score elsewhere"}};
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
