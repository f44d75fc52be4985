// What is scored. Every objective is an integer table of scores [states x (actions + 1)], the last column being "no
// action"; no action, or one that the state lacks, scores as what takes place instead (Chain::taken), but that it never
// counts as agreement. An individual's tally is the sum of the table along its roll-outs or over all states. Integers
// make a tally independent of the order of summation, hence of threads, SIMD width and machine. Quantities that are not
// integral (Q-values, mean rewards) are rounded once, to fixed point, when the table is made.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/error.hpp"
#include "common/named.hpp"
#include "common/tree/tree.hpp"

namespace coppice {

enum class ObjectiveKind : std::uint8_t {
  agreement = 0,        // 1 where the tree's action is the policy's, along the walk (thesis IV, Algorithm 1)
  q_value = 1,          // Q(s, tree's action) along the walk, fixed point (thesis 5-1-1, Algorithm 1)
  shaped = 2,           // weights by predicate along the walk (thesis 5-1-2, Algorithm 2)
  coverage = 3,         // states in which tree and policy agree; no walk (thesis Table IV, first row)
  visits = 4,           // the same, each state weighted by its visits; no walk
  expected_return = 5,  // mean reward recorded for (s, a) along the walk, fixed point; called "return" in text
  regret = 6,           // cost: V(s) - Q(s, tree's action), each state as often as it was visited; no walk
  seen = 7,             // coverage of the states that were visited `threshold` times or more; no walk
  collisions = 8,  // cost: steps of the walk that are collisions, where the chain says which tries were; else those
                   // whose recorded mean reward is `threshold` or less
  unknown = 9,     // cost: steps of the walk whose (s, a) was never tried, so that nothing is known of them
};
template <>
inline constexpr std::array kNames<ObjectiveKind> = names("agreement", "q_value", "shaped", "coverage", "visits",
                                                          "return", "regret", "seen", "collisions", "unknown");
inline constexpr std::uint8_t kObjectiveKinds = kNames<ObjectiveKind>.size();

// Fixed point of q_value and expected_return: value = score / kScoreOne where all of a chain's values lie within
// +-kFineScoredValue; where they do not, the unit is the largest power of two with which none of its scores passes
// 2^31, so that a sum over kMaxWalkedSteps steps stays far below 2^63. Values beyond +-kMaxScoredValue are refused.
inline constexpr double kScoreOne = 1048576.0;  // 2^20
inline constexpr double kFineScoredValue = 2048.0;
inline constexpr double kMaxScoredValue = 1099511627776.0;  // 2^40
// Fixed point of regret, which is a mean: value = score / kRegretOne (less where Q-values are further apart than
// 2 x kFineScoredValue, as above), the mean over all visits of
//   regret(s, a) = max over b of Q(s, b) - Q(s, a)                    [states x actions], unit of a Q-value
// (the loss that Ross and Bagnell 2014, "Reinforcement and imitation learning via interactive no-regret learning",
// imitate by: a wrong action that costs nothing is no error). No action counts as the worst one.
inline constexpr double kRegretOne = 1099511627776.0;        // 2^40
inline constexpr double kMaxThreshold = 9007199254740992.0;  // 2^53
inline constexpr std::size_t kMaxShapedRules = 32;
inline constexpr std::size_t kMaxShapedConditions = 32;

// If any condition holds in the state: `right` when the tree's action is the policy's, else `wrong`.
struct ShapedRule {
  std::vector<Node> any_of;  // conditions; empty: holds in every state
  std::int32_t right = 1;
  std::int32_t wrong = 0;
  bool operator==(const ShapedRule&) const = default;
};

struct Objective {
  ObjectiveKind kind = ObjectiveKind::agreement;
  std::vector<ShapedRule> rules = {};  // shaped only: the first rule that holds scores the state
  double threshold = 0.0;              // seen: fewest visits; collisions: highest mean reward; others: 0
  bool operator==(const Objective&) const = default;
};

constexpr bool along_walk(ObjectiveKind kind) {
  return kind != ObjectiveKind::coverage && kind != ObjectiveKind::visits && kind != ObjectiveKind::regret &&
         kind != ObjectiveKind::seen;
}
// The fewer the better.
constexpr bool is_cost(ObjectiveKind kind) {
  return kind == ObjectiveKind::regret || kind == ObjectiveKind::collisions || kind == ObjectiveKind::unknown;
}
constexpr bool has_threshold(ObjectiveKind kind) {
  return kind == ObjectiveKind::seen || kind == ObjectiveKind::collisions;
}

// The rules of thesis Algorithm 2 (page 5-8): trash on s3, s4 or s5: +8 / -4; else a wall on s3: +1 / -2; else +1 / 0.
// We differ: the thesis prints "s0 = 0" in the second rule, its prose says s3; we follow the prose.
// Errors: the vocabulary has no s3, s4, s5.
Result<std::vector<ShapedRule>> thesis_rules(const Vocabulary& vocabulary);

// Scores of one objective on one chain.
struct ScoreTable {
  std::vector<std::int64_t> scores;  // [states x (actions + 1)]
  double unit = 1.0;                 // value = sum of scores / unit
  std::int64_t best_per_step = 1;  // along the walk: the largest score; over states: the sum of the largest. Of a cost
                                   // the worst
};

// Errors: shaped without rules or with too many, or with a condition outside the vocabulary; a value beyond
// kMaxScoredValue; a threshold that is not finite, or beyond kMaxThreshold.
Result<ScoreTable> make_score_table(const Chain& chain, const Objective& objective);

}  // namespace coppice
