#include "coordinator/runs/answer.hpp"

#include <gtest/gtest.h>
#include <initializer_list>
#include <optional>
#include <string>

#include "common/tree/text.hpp"
#include "tests/coordinator/runs/learned_room.hpp"
#include "tests/temporary_folder.hpp"

namespace coppice {
namespace {

struct Entry {
  const char* tree;
  double on_chain;  // return that the run is said to have measured
};

class AnswerTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { chain_.emplace(learned_room()); }
  static void TearDownTestSuite() { chain_.reset(); }

  AnswerTest() {
    config_.ga.search = Search::front;
    config_.rollout.steps = 100;
    config_.front.prefer = Prefer::balance;
  }

  Study study(bool with_world) {
    const std::string path = folder_ / (with_world ? "world.coppice" : "chain.coppice");
    auto made = Study::create(
        path, *chain_,
        with_world ? StudyWorld{"uav", std::string(default_room())} : StudyWorld{std::string(kNoWorld), ""}, {});
    return std::move(made.value());
  }

  static Front front(std::initializer_list<Entry> entries) {
    Front front;
    front.measures = {measure_of(ObjectiveKind::agreement), measure_of(ObjectiveKind::expected_return),
                      measure_of(ObjectiveKind::collisions), kNodesMeasure};
    for (const Entry& entry : entries) {
      Tree tree = parse_tree(entry.tree, chain_->vocabulary()).value();
      const double nodes = static_cast<double>(tree.size());
      front.members.push_back({std::move(tree), 0.0, {0.9, entry.on_chain, 0.0, nodes}});
    }
    return front;
  }

  testing::TemporaryFolder folder_;
  EvolveConfig config_;
  static std::optional<Chain> chain_;
};

std::optional<Chain> AnswerTest::chain_;

// Never moves into a wall, and turns when one is ahead; or bumps; or spins.
constexpr const char* kCareful = "(selector (sequence s3=0 turn_left) move)";
constexpr const char* kLarger = "(selector (sequence s3=0 s3=0 turn_left) (sequence s3=0 turn_left) move)";
constexpr const char* kBumps = "move";
constexpr const char* kSpins = "turn_left";

TEST_F(AnswerTest, IsNeverATreeThatCollidesInTheSimulatorWhateverTheChainPromises) {
  const Study with_world = study(true);
  const Front of_two = front({{kBumps, 900.0}, {kCareful, 10.0}});
  config_.front.prefer = Prefer::expected_return;
  const auto answer = choose_answer(with_world, of_two, config_, {});
  ASSERT_TRUE(answer.has_value()) << answer.error().message;
  EXPECT_TRUE(answer->simulated);
  EXPECT_EQ(answer->tried, 2U);
  EXPECT_GT(answer->episodes, 0U);
  if (answer->policy.collisions.mean == 0.0) {
    EXPECT_EQ(answer->member, 1U);
    EXPECT_EQ(answer->tree.collisions.mean, 0.0);
  } else {
    EXPECT_LE(answer->tree.collisions.mean - answer->tree.collisions.margin,
              answer->policy.collisions.mean + answer->policy.collisions.margin);
  }
}

TEST_F(AnswerTest, IsTheSmallerOfTwoThatDoTheSame) {
  const Study with_world = study(true);
  config_.front.prefer = Prefer::expected_return;
  const auto answer = choose_answer(with_world, front({{kLarger, 20.0}, {kCareful, 10.0}}), config_, {});
  ASSERT_TRUE(answer.has_value()) << answer.error().message;
  EXPECT_EQ(answer->member, 1U);
}

TEST_F(AnswerTest, IsTheSameEveryTime) {
  const Study with_world = study(true);
  const Front all = front({{kBumps, 5.0}, {kCareful, 10.0}, {kLarger, 9.0}, {kSpins, 1.0}});
  const auto once = choose_answer(with_world, all, config_, {});
  const auto again = choose_answer(with_world, all, config_, {});
  ASSERT_TRUE(once.has_value() && again.has_value());
  EXPECT_EQ(once->member, again->member);
  EXPECT_EQ(to_text(*once), to_text(*again));
  EXPECT_EQ(once->tree.reward.mean, again->tree.reward.mean);
  EXPECT_EQ(once->policy.reward.margin, again->policy.reward.margin);
}

TEST_F(AnswerTest, WithoutASimulatorIsWhatTheChainSaysIsBest) {
  const Study chain_only = study(false);
  config_.front.prefer = Prefer::expected_return;
  const auto answer = choose_answer(chain_only, front({{kSpins, 1.0}, {kCareful, 10.0}, {kBumps, 3.0}}), config_, {});
  ASSERT_TRUE(answer.has_value()) << answer.error().message;
  EXPECT_FALSE(answer->simulated);
  EXPECT_EQ(answer->member, 1U);
  EXPECT_EQ(answer->tree.reward.mean, 10.0);
}

TEST_F(AnswerTest, SaysPlainlyThatATreeIsNotGoodEnoughAndWhatToTry) {
  const Study chain_only = study(false);
  const auto answer = choose_answer(chain_only, front({{kSpins, -5000.0}}), config_, {});
  ASSERT_TRUE(answer.has_value()) << answer.error().message;
  EXPECT_FALSE(answer->good);
  const std::string text = to_text(*answer);
  EXPECT_NE(text.find("This tree is not good enough"), std::string::npos) << text;
  EXPECT_NE(text.find("--set ga.max_nodes=N"), std::string::npos) << text;
}

TEST_F(AnswerTest, StopsWhenItIsToldTo) {
  const Study with_world = study(true);
  const auto answer = choose_answer(with_world, front({{kCareful, 1.0}}), config_, {[] { return false; }});
  ASSERT_FALSE(answer.has_value());
  EXPECT_EQ(answer.error().kind, ErrorKind::interrupted);
}

}  // namespace
}  // namespace coppice
