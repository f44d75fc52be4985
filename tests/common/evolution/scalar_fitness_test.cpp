#include "common/evolution/scalar_fitness.hpp"

#include <gtest/gtest.h>

#include "tests/coordinator/evolution/small_world.hpp"

namespace coppice {
namespace {

using testing::small_chain;

TEST(ScalarFitness, AddsTheSizeTermOnceAgreementExceedsTheThreshold) {
  const auto fitness = ScalarFitness::make(small_chain(), FitnessConfig{}).value();
  ASSERT_EQ(fitness.objectives().size(), 1U);
  EXPECT_DOUBLE_EQ(fitness.of({40, 89, 100, {89}}), 0.89);
  EXPECT_DOUBLE_EQ(fitness.of({40, 90, 100, {90}}), 0.9);
  EXPECT_DOUBLE_EQ(fitness.of({40, 91, 100, {91}}), 0.91 + 0.5);
  EXPECT_DOUBLE_EQ(fitness.of({20, 91, 100, {91}}), 0.91 + 1.0);
  EXPECT_DOUBLE_EQ(fitness.of({3, 91, 100, {91}}), 0.91 + 1.0);
}

TEST(ScalarFitness, NormalisesEachObjectiveAndWeighsIt) {
  const Chain chain = small_chain();
  FitnessConfig config;
  config.agreement = 2.0;
  config.coverage = 3.0;
  config.visits = 0.5;
  config.size_weight = 0.0;
  const auto fitness = ScalarFitness::make(chain, config).value();
  ASSERT_EQ(fitness.objectives().size(), 3U);
  EXPECT_EQ(fitness.objectives()[1].kind, ObjectiveKind::coverage);
  EXPECT_EQ(fitness.objectives()[2].kind, ObjectiveKind::visits);
  std::uint64_t visits = 0;
  for (const std::uint64_t v : chain.parts().visits) {
    visits += v;
  }
  EXPECT_DOUBLE_EQ(fitness.of({5, 40, 200, {40, 27, static_cast<std::int64_t>(visits)}}),
                   2.0 * 0.2 + 3.0 * 27.0 / 81.0 + 0.5);
}

TEST(ScalarFitness, TakesTheRulesOfTheConfiguration) {
  FitnessConfig config;
  config.agreement = 0.0;
  config.shaped = 1.0;
  config.rules = {{{"a=0", "d<=1"}, 8, -4}, {{}, 1, 0}};
  const auto fitness = ScalarFitness::make(small_chain(), config).value();
  ASSERT_EQ(fitness.objectives().size(), 1U);
  EXPECT_EQ(fitness.objectives()[0].rules[0].any_of[1], Node::condition(3, Op::less_equal, 1));
  EXPECT_DOUBLE_EQ(fitness.of({5, 0, 100, {400}}), 0.5);
  EXPECT_DOUBLE_EQ(fitness.of({5, 0, 100, {-400}}), -0.5);
}

TEST(ScalarFitness, WhereNothingScoresAboveZeroItIsTheMeanValue) {
  ChainParts parts = small_chain().parts();
  for (double& reward : parts.reward_sum) {
    reward = reward == 0.0 ? 0.0 : -1.0;
  }
  FitnessConfig config;
  config.agreement = 0.0;
  config.expected_return = 1.0;
  const auto fitness = ScalarFitness::make(Chain::make(parts).value(), config).value();
  EXPECT_DOUBLE_EQ(fitness.of({5, 0, 100, {static_cast<std::int64_t>(-50 * kScoreOne)}}), -0.5);
}

TEST(ScalarFitness, AnIndividualWithoutAResultIsBelowEveryOther) {
  const auto fitness = ScalarFitness::make(small_chain(), FitnessConfig{}).value();
  EXPECT_EQ(fitness.of({5, 0, 0, {0}}), ScalarFitness::kNone);
  EXPECT_EQ(agreement_of({5, 0, 0, {0}}), 0.0);
}

}  // namespace
}  // namespace coppice
