// How a run of evolution is set up: everything that, with a chain, decides its result. Plain values; the defaults are
// thesis Table III. config_keys.hpp names every key once, for whoever spells or sends them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/error.hpp"
#include "common/evolution/measure.hpp"
#include "common/fitness/job.hpp"
#include "common/fitness/objective.hpp"
#include "common/named.hpp"
#include "common/tree/random_tree.hpp"
#include "common/tree/vocabulary.hpp"

namespace coppice {

inline constexpr std::uint32_t kMaxGenerations = 100'000;
inline constexpr std::uint32_t kMaxPopulation = 1'000'000;
inline constexpr std::uint32_t kMaxGuidedSteps = 10'000;
inline constexpr std::uint32_t kMaxDemes = 4096;
inline constexpr double kMaxWeight = 1e6;
inline constexpr double kMaxRuleScore = 1e6;

// How generations follow each other: one number decides (thesis), or a front of trees that none other beats in every
// measure (NSGA-II with local search, front_search.hpp).
enum class Search : std::uint8_t { scalar = 0, front = 1 };
template <>
inline constexpr std::array kNames<Search> = names("scalar", "front");
// Which trees there are: any, or those that ask before they act (guard.hpp).
enum class Form : std::uint8_t { free = 0, guarded = 1 };
template <>
inline constexpr std::array kNames<Form> = names("free", "guarded");
// What is done to every child: nothing, or simplify() that holds in every possible state, so that spare nodes go.
enum class Simplification : std::uint8_t { none = 0, lossless = 1 };
template <>
inline constexpr std::array kNames<Simplification> = names("none", "lossless");
// What half of the first generation is made of: grown trees like the rest, single-condition branches, or decision lists
// grown greedily from the policy (seeding.hpp).
enum class Seeding : std::uint8_t { none = 0, branches = 1, greedy = 2 };
template <>
inline constexpr std::array kNames<Seeding> = names("none", "branches", "greedy");
// Who chooses the answer among the trees of a front: the rule front.pick, on the chain; or what they are worth where
// they will be used (coordinator/runs/answer.hpp), by a preference.
enum class Prefer : std::uint8_t { pick = 0, balance = 1, expected_return = 2, agreement = 3, coverage = 4, size = 5 };
template <>
inline constexpr std::array kNames<Prefer> = names("pick", "balance", "return", "agreement", "coverage", "size");
// Who sends a deme migrants: its neighbour in a ring, or its neighbour in a ring drawn anew for each epoch.
enum class Migration : std::uint8_t { ring = 0, random = 1 };
template <>
inline constexpr std::array kNames<Migration> = names("ring", "random");
// How policy_share of a mixed acting policy moves to policy_share_end over the generations.
enum class Schedule : std::uint8_t { constant = 0, linear = 1, step = 2 };
template <>
inline constexpr std::array kNames<Schedule> = names("constant", "linear", "step");

// [ga]
struct GaConfig {
  std::uint32_t generations = 400;  // G
  std::uint32_t population = 100;   // M, of all demes together
  double tournament = 0.08;         // s, share of the population in one tournament; at least one individual
  double crossover = 0.5;           // P_c, share of a generation that crossover makes
  double mutation = 0.3;            // P_m, probability that a child is mutated
  double headless_chicken = 0.1;    // P_hcc, probability that a mutation is a macro mutation
  std::uint32_t max_depth = 3;      // D_d, edges
  std::uint32_t max_children = 4;   // D_c
  std::uint32_t elites = 1;         // individuals that pass unchanged; not in the thesis, 0 switches it off

  std::uint32_t max_nodes = kMaxTreeNodes;       // of a child
  std::uint32_t max_conditions = kMaxTreeNodes;  // of a child: the tests of a decision tree
  Form form = Form::free;
  Search search = Search::scalar;
  Simplification simplify = Simplification::none;
  Seeding seeding = Seeding::none;
  double edits = 0.0;         // share of the mutations that are a few small edits instead (Breeding::edit)
  double local_search = 0.0;  // search front: share of the children that are edits of trees on the front
  double guided = 0.0;        // search front: share of the children that then climb by guided edits (guided_climb.hpp)
  std::uint32_t guided_steps = 100;  // edits that one of them may climb
  std::string founders;              // trees of the first generation, with ; between (seeding.hpp)

  // Demes are populations of their own; without others there is nothing to exchange, and an epoch means nothing.
  std::uint32_t demes = 1;
  std::uint32_t epoch = 20;    // generations between two exchanges; 0: none until the end
  std::uint32_t migrants = 4;  // that a deme is given when an epoch begins
  Migration migration = Migration::ring;

  TreeShape shape() const { return {max_depth, max_children, max_nodes, max_conditions, form == Form::guarded}; }
  bool operator==(const GaConfig&) const = default;
};

// [rollout]
struct RolloutConfig {
  std::uint32_t rollouts = 5;          // k
  std::uint32_t steps = 100;           // t
  std::uint32_t final_rollouts = 200;  // the fixed, larger sample on which the best of all generations is chosen
  Acting acting = Acting::tree;
  double policy_share = 0.0;  // acting mixed: probability, per step, that the RL policy acts
  Schedule schedule = Schedule::constant;
  double policy_share_end = 0.0;  // in the last generation, by the schedule
  Start start = Start::initial;
  Method method = Method::rollouts;
  Method final_method = Method::rollouts;  // of the last comparison: rollouts, final_rollouts of them, or exact
  double gamma = 0.99;                     // method discounted: step i weighs gamma^i
  bool operator==(const RolloutConfig&) const = default;
};

// [[fitness.rule]], a rule of the shaped objective as text: "s3=3", "x<=2"
struct RuleConfig {
  std::vector<std::string> any_of;  // empty: holds in every state
  std::int32_t right = 1;
  std::int32_t wrong = 0;
  bool operator==(const RuleConfig&) const = default;
};

// [fitness]: scalar = sum of weight x normalised objective, plus the size term (scalar_fitness.hpp)
struct FitnessConfig {
  double agreement = 1.0;  // weights; an objective of weight 0 is not evaluated
  double q_value = 0.0;
  double shaped = 0.0;
  double coverage = 0.0;
  double visits = 0.0;
  double expected_return = 0.0;  // key "return"
  double regret = 0.0;           // costs lower the fitness
  double seen = 0.0;
  double collisions = 0.0;
  double unknown = 0.0;
  double seen_visits = 1000.0;      // fewest visits of a state that counts as seen
  double collision_reward = -10.0;  // a step collides when the mean reward recorded for it is this or less
  double size_threshold = 0.9;      // the size term counts once agreement along the walk exceeds this
  double size_nodes = 20.0;         // full size term at so many nodes or fewer
  double size_weight = 1.0;         // 0 switches the size term off
  std::vector<RuleConfig> rules;    // of the shaped objective; empty: thesis_rules()

  double weight(ObjectiveKind kind) const;
  bool operator==(const FitnessConfig&) const = default;
};

// Agreement, coverage, return, collisions, nodes.
std::vector<Measure> front_objectives();

// [front], of search front
struct FrontConfig {
  // What trees are compared by. Others are measured if they have a weight in [fitness].
  std::vector<Measure> objectives = front_objectives();
  std::uint32_t max_nodes = 20;  // of a tree that is kept on the front
  std::uint32_t restarts = 0;    // times that the search begins anew; the last part goes on from what all of them kept
  std::uint32_t members = 200;   // that are kept, by each deme too; the most crowded go first
  std::string pick = "best fitness";  // which of them is the answer (pick.hpp)
  Prefer prefer = Prefer::pick;
  bool operator==(const FrontConfig&) const = default;
};

struct EvolveConfig {
  std::uint64_t seed = 1;
  GaConfig ga;
  RolloutConfig rollout;
  FitnessConfig fitness;
  FrontConfig front;
  bool operator==(const EvolveConfig&) const = default;
};

// What can be checked only as a whole, or needs the vocabulary: elites fewer than the population, walks within
// kMaxWalkedSteps, a schedule only where it can act, some weight above 0, rules that speak of this vocabulary. With
// values in the ranges of config_keys.hpp, all that a search relies on.
Result<void> check_search(const EvolveConfig& config, const Vocabulary& vocabulary);

// The objectives of weight above 0 and those of `also`, in the order of ObjectiveKind. Errors: as check_search() for
// the rules.
Result<std::vector<Objective>> objectives_of(const FitnessConfig& fitness, const Vocabulary& vocabulary,
                                             std::span<const Measure> also = {});
// What a run of this configuration measures: with the front's objectives, if it searches one.
Result<std::vector<Objective>> objectives_of(const EvolveConfig& config, const Vocabulary& vocabulary);

// The number that stands for the final sample in Job::generation; no generation has it.
inline constexpr std::uint32_t kFinalGeneration = 0xFFFFFFFF;
// The same for the one sample that all generations of a front search share, so that what is kept of earlier ones can be
// compared with what is new.
inline constexpr std::uint32_t kFrontGeneration = 0xFFFFFFFE;

// What is asked of the individuals of a generation: config.rollout with config.seed; final_rollouts for
// kFinalGeneration.
Job job_of(const EvolveConfig& config, std::vector<Objective> objectives, std::uint32_t generation);

}  // namespace coppice
