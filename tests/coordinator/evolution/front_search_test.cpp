#include <algorithm>
#include <gtest/gtest.h>
#include <optional>
#include <vector>

#include "common/evolution/dominance.hpp"
#include "common/tree/guard.hpp"
#include "coordinator/evolution/evolve.hpp"
#include "tests/coordinator/evolution/small_world.hpp"

namespace coppice {
namespace {

using testing::small_chain;
using testing::WalkingEvaluator;

EvolveConfig front_config() {
  EvolveConfig config;
  config.seed = 42;
  config.ga.search = Search::front;
  config.ga.generations = 12;
  config.ga.population = 40;
  config.ga.edits = 0.5;
  config.ga.local_search = 0.3;
  config.ga.seeding = Seeding::greedy;
  config.ga.max_nodes = 16;
  config.rollout.rollouts = 2;
  config.rollout.steps = 30;
  config.rollout.final_rollouts = 10;
  config.front.max_nodes = 12;
  config.front.restarts = 2;
  config.front.members = 15;
  config.front.objectives = {measure_of(ObjectiveKind::agreement), measure_of(ObjectiveKind::coverage), kNodesMeasure};
  return config;
}

class FrontSearchTest : public ::testing::Test {
 protected:
  Result<Evolved> run(const EvolveConfig& config, std::optional<Checkpoint> start = std::nullopt) {
    checkpoints_.clear();
    return evolve(chain_, config, evaluator_, std::move(start),
                  {[this](std::span<const GenerationRecord>, const Checkpoint& checkpoint) -> Result<void> {
                    checkpoints_.push_back(checkpoint);
                    return {};
                  }});
  }

  Chain chain_ = small_chain();
  WalkingEvaluator evaluator_{chain_};
  std::vector<Checkpoint> checkpoints_;
};

TEST_F(FrontSearchTest, ResumesFromAnyCheckpointToTheVerySameFront) {
  const EvolveConfig config = front_config();
  const auto expected = run(config);
  ASSERT_TRUE(expected.has_value()) << expected.error().message;
  const std::vector<Checkpoint> whole = checkpoints_;
  ASSERT_EQ(whole.size(), config.ga.generations);
  for (std::size_t g = 0; g < whole.size(); ++g) {
    const auto resumed = run(config, whole[g]);
    ASSERT_TRUE(resumed.has_value()) << resumed.error().message;
    EXPECT_EQ(*resumed, *expected) << "from generation " << g;
    EXPECT_TRUE(std::equal(checkpoints_.begin(), checkpoints_.end(), whole.begin() + static_cast<std::ptrdiff_t>(g) + 1,
                           whole.end()));
  }
}

TEST_F(FrontSearchTest, ThatClimbsResumesToTheVerySameFrontTooWithinItsLimits) {
  EvolveConfig config = front_config();
  config.ga.generations = 5;
  config.ga.population = 12;
  config.ga.guided = 0.7;
  config.ga.max_conditions = 3;
  config.ga.form = Form::guarded;
  const auto expected = run(config);
  ASSERT_TRUE(expected.has_value()) << expected.error().message;
  for (const FrontMember& member : expected->front.members) {
    EXPECT_TRUE(is_guarded(member.tree));
    EXPECT_LE(*value_of(expected->front, member, kConditionsMeasure), 3.0);
  }
  const std::vector<Checkpoint> whole = checkpoints_;
  for (const Checkpoint& from : whole) {
    const auto resumed = run(config, from);
    ASSERT_TRUE(resumed.has_value()) << resumed.error().message;
    EXPECT_EQ(*resumed, *expected) << "from generation " << from.generation;
  }
}

TEST_F(FrontSearchTest, NothingOnTheFrontIsBeatenOrTooLarge) {
  const EvolveConfig config = front_config();
  const auto evolved = run(config);
  ASSERT_TRUE(evolved.has_value());
  const Front& front = evolved->front;
  ASSERT_FALSE(front.members.empty());
  EXPECT_LE(front.members.size(), config.front.members);
  std::vector<double> values;
  for (const FrontMember& member : front.members) {
    EXPECT_LE(member.tree.size(), config.front.max_nodes);
    for (const Measure measure : config.front.objectives) {
      const double value = *value_of(front, member, measure);
      values.push_back(is_cost(measure) ? value : -value);
    }
  }
  for (const std::uint32_t rank : ranks_of({values, config.front.objectives.size()})) {
    EXPECT_EQ(rank, 0U);
  }
}

TEST_F(FrontSearchTest, FindsThePlantedPolicyAndWhatLiesBelowIt) {
  EvolveConfig config = front_config();
  config.ga.generations = 60;
  config.ga.population = 60;
  const auto evolved = run(config);
  ASSERT_TRUE(evolved.has_value());
  const Front& front = evolved->front;
  const auto whole = pick(front, *parse_pick("best nodes with coverage>=1 and agreement>=1"));
  ASSERT_TRUE(whole.has_value()) << "the policy is a tree of 8 nodes";
  EXPECT_LE(front.members[*whole].tree.size(), 8U);
  EXPECT_EQ(front.members.front().tree.size(), 1U) << "no tree is smaller than a single action";
}

TEST_F(FrontSearchTest, TheAnswerIsTheOneThatTheRulePicks) {
  EvolveConfig config = front_config();
  config.front.pick = "best coverage with nodes<=3";
  const auto evolved = run(config);
  ASSERT_TRUE(evolved.has_value());
  const auto expected = pick(evolved->front, *parse_pick(config.front.pick));
  ASSERT_TRUE(expected.has_value());
  EXPECT_EQ(evolved->best.tree, evolved->front.members[*expected].tree);
}

TEST_F(FrontSearchTest, EveryGenerationIsMeasuredOnOneSampleAndTheFrontOnAnother) {
  ASSERT_TRUE(run(front_config()).has_value());
  for (std::size_t call = 0; call + 1 < evaluator_.calls.size(); ++call) {
    EXPECT_EQ(evaluator_.calls[call].job, evaluator_.calls.front().job);
  }
  EXPECT_EQ(evaluator_.calls.back().job.generation, kFinalGeneration);
}

TEST_F(FrontSearchTest, NoTwoOfAPopulationMeanTheSameAtTheSameSize) {
  ASSERT_TRUE(run(front_config()).has_value());
  // The first generation of a part is as it was grown.
  const std::vector<Tree>& population = checkpoints_.back().population;
  for (std::size_t a = 0; a < population.size(); ++a) {
    for (std::size_t b = a + 1; b < population.size(); ++b) {
      EXPECT_FALSE(population[a] == population[b]);
    }
  }
}

TEST_F(FrontSearchTest, InterruptedKeepsTheFrontSoFar) {
  evaluator_.stop_at = 6;
  const auto evolved = run(front_config());
  ASSERT_TRUE(evolved.has_value());
  EXPECT_TRUE(evolved->interrupted);
  EXPECT_FALSE(evolved->front.members.empty());
  EXPECT_EQ(evolved->final_steps, 0U);
}

}  // namespace
}  // namespace coppice
