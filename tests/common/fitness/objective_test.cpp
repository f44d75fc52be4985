// Score tables of objectives that need more than the policy, held against tables worked out by hand.
#include "common/fitness/objective.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <vector>

namespace coppice {
namespace {

// Two states and two actions. State 0: visited 3 times, Q 4 and 1; state 1: visited once, Q 2 and 2; its second action
// was never tried. Rewards and Q-values times `scale`.
Chain two_states(double scale = 1.0) {
  ChainParts parts;
  parts.vocabulary = {{{"a", {0, 1}, true, false}}, {"stay", "go"}};
  parts.features = {0, 1};
  parts.row_begin = {0, 1, 2, 3, 3};
  parts.successor = {0, 1, 0};
  parts.count = {2, 1, 1};
  parts.reward_sum = {2.0, -10.0, -1.0, 0.0};
  parts.q = {4.0, 1.0, 2.0, 2.0};
  parts.policy = {ActionId{0}, ActionId{0}};
  parts.visits = {3, 1};
  for (std::vector<double>* values : {&parts.reward_sum, &parts.q}) {
    for (double& value : *values) {
      value *= scale;
    }
  }
  auto chain = Chain::make(std::move(parts));
  EXPECT_TRUE(chain.has_value()) << (chain ? "" : chain.error().message);
  return std::move(*chain);
}

std::vector<std::int64_t> scores_of(ObjectiveKind kind, double threshold = 0.0) {
  const auto table = make_score_table(two_states(), {kind, {}, threshold});
  EXPECT_TRUE(table.has_value());
  return table->scores;
}

using Scores = std::vector<std::int64_t>;

TEST(Objective, RegretIsWhatAnActionLosesAsOftenAsItsStateIsVisited) {
  const auto table = make_score_table(two_states(), {ObjectiveKind::regret});
  const auto lost = static_cast<std::int64_t>(3.0 * 0.75 * kRegretOne);  // 4 - 1, in three visits of four
  EXPECT_EQ(table->scores, (Scores{0, lost, lost, 0, 0, 0})) << "no action counts as the worst one";
  EXPECT_EQ(table->unit, kRegretOne);
  EXPECT_EQ(table->best_per_step, lost);
}

TEST(Objective, SeenIsCoverageOfTheStatesVisitedOftenEnough) {
  EXPECT_EQ(scores_of(ObjectiveKind::seen, 1), (Scores{1, 0, 0, 1, 0, 0}));
  EXPECT_EQ(scores_of(ObjectiveKind::seen, 2), (Scores{1, 0, 0, 0, 0, 0}));
  EXPECT_EQ(make_score_table(two_states(), {ObjectiveKind::seen, {}, 1})->best_per_step, 2);
}

TEST(Objective, CollisionsAreStepsThatCostAsMuchAndUnknownOnesThoseNeverTried) {
  EXPECT_EQ(scores_of(ObjectiveKind::collisions, -10.0), (Scores{0, 1, 0, 0, 0, 0}));
  EXPECT_EQ(scores_of(ObjectiveKind::collisions, -1.0), (Scores{0, 1, 0, 1, 0, 0}));
  EXPECT_EQ(scores_of(ObjectiveKind::collisions, 0.0), (Scores{0, 1, 0, 1, 0, 0})) << "never tried: no reward recorded";
  EXPECT_EQ(scores_of(ObjectiveKind::unknown), (Scores{0, 0, 0, 0, 1, 0}));
}

TEST(Objective, LargeRewardsAreScoredInACoarserUnitThatKeepsTheirValue) {
  constexpr double kScale = 1e6;
  for (const ObjectiveKind kind : {ObjectiveKind::expected_return, ObjectiveKind::q_value, ObjectiveKind::regret}) {
    const auto small = make_score_table(two_states(), {kind});
    const auto large = make_score_table(two_states(kScale), {kind});
    ASSERT_TRUE(small.has_value() && large.has_value()) << name_of(kind);
    EXPECT_LT(large->unit, small->unit) << name_of(kind);
    for (std::size_t i = 0; i < small->scores.size(); ++i) {
      const double expected = static_cast<double>(small->scores[i]) / small->unit * kScale;
      EXPECT_NEAR(static_cast<double>(large->scores[i]) / large->unit, expected, 1e-3) << name_of(kind) << ' ' << i;
      EXPECT_LE(std::abs(static_cast<double>(large->scores[i])), std::ldexp(1.0, 52)) << name_of(kind) << ' ' << i;
    }
  }
  EXPECT_EQ(make_score_table(two_states(200.0), {ObjectiveKind::expected_return})->unit, kScoreOne) << "2000: as ever";
  const auto beyond = make_score_table(two_states(1e13), {ObjectiveKind::expected_return});
  ASSERT_FALSE(beyond.has_value());
  EXPECT_NE(beyond.error().message.find("divide the rewards of the source"), std::string::npos);
}

TEST(Objective, AThresholdHasToBeANumber) {
  for (const double threshold : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    EXPECT_FALSE(make_score_table(two_states(), {ObjectiveKind::seen, {}, threshold}).has_value());
  }
}

}  // namespace
}  // namespace coppice
