#include "coordinator/report/score.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <vector>

#include "common/tree/text.hpp"

namespace coppice {
namespace {

// Three states of the windy grid's first row of steps, where there is no wind: right, right, then down. What
// comes after is known to the simulator only.
Chain three_states(const World& world) {
  ChainParts parts;
  parts.vocabulary = vocabulary_of(world);
  parts.features = {0, 3, 1, 3, 2, 3};
  const std::size_t actions = parts.vocabulary.actions.size();
  parts.row_begin.assign(3 * actions + 1, 0);
  parts.reward_sum.assign(3 * actions, 0.0);
  parts.q.assign(3 * actions, 0.0);
  const ActionId right = *parts.vocabulary.find_action("right");
  parts.policy = {right, right, *parts.vocabulary.find_action("down")};
  parts.visits = {5, 4, 3};
  auto chain = Chain::make(std::move(parts));
  EXPECT_TRUE(chain) << chain.error().message;
  return std::move(*chain);
}

class WindyScore : public ::testing::Test {
 protected:
  Score score(const char* text, const SimulateSettings& settings) const {
    const auto tree = parse_tree(text, chain_.vocabulary());
    EXPECT_TRUE(tree) << tree.error().message;
    auto score = score_tree(world_, chain_, *tree, settings);
    EXPECT_TRUE(score) << score.error().message;
    return *score;
  }

  World world_{WorldKind::windy, ""};
  Chain chain_ = three_states(world_);
};

TEST(Estimate, IsMeanAndNormalIntervalOfTheMean) {
  const Estimate four = estimate({1.0, 2.0, 3.0, 4.0});
  EXPECT_DOUBLE_EQ(four.mean, 2.5);
  EXPECT_NEAR(four.margin, 1.96 * std::sqrt(5.0 / 3.0) / 2.0, 1e-12);
  EXPECT_DOUBLE_EQ(estimate({7.0}).mean, 7.0);
  EXPECT_DOUBLE_EQ(estimate({7.0}).margin, 0.0);
}

TEST(ControllerScore, AnEpisodeIsOneSample) {
  const ControllerScore score =
      controller_score({{.reward = 10, .steps = 4, .matches = 4, .collisions = 0, .unknown = 0},
                        {.reward = -2, .steps = 2, .matches = 0, .collisions = 3, .unknown = 1}});
  EXPECT_EQ(score.episodes, 2U);
  EXPECT_EQ(score.steps, 6U);
  EXPECT_DOUBLE_EQ(score.agreement.mean, 0.5);
  EXPECT_DOUBLE_EQ(score.reward.mean, 4.0);
  EXPECT_EQ(score.total_collisions, 3U);
  EXPECT_DOUBLE_EQ(score.collisions.mean, 1.5);
  EXPECT_EQ(score.unknown_steps, 1U);
}

TEST_F(WindyScore, CountsWhatTheWalkByHandGives) {
  // The tree goes right four times: (0,3) and (1,3) as the policy, (2,3) otherwise, (3,3) is unknown. The
  // policy goes right, right, down and is then where the chain knows nothing.
  const Score result = score("right", {.episodes = 3, .steps = 4, .seed = 1});
  EXPECT_EQ(result.states, 3U);
  EXPECT_EQ(result.entries, 12U);
  EXPECT_EQ(result.policy.matching_states, 3U);
  EXPECT_EQ(result.tree.matching_states, 2U);
  EXPECT_EQ(result.tree.steps, 12U);
  EXPECT_DOUBLE_EQ(result.tree.agreement.mean, 0.5);
  EXPECT_DOUBLE_EQ(result.tree.agreement.margin, 0.0);
  EXPECT_DOUBLE_EQ(result.tree.reward.mean, -4.0);
  EXPECT_EQ(result.tree.unknown_steps, 3U);
  EXPECT_DOUBLE_EQ(result.policy.agreement.mean, 0.75);
  EXPECT_EQ(result.policy.unknown_steps, 3U);
}

TEST_F(WindyScore, NodesAreCountedBeforeAndAfterBothPrunings) {
  // y=3 holds in every state of the chain, but not in every state of the grid.
  const Score result = score("(sequence (selector (sequence y=3 right) up))", {.episodes = 2, .steps = 1, .seed = 1});
  EXPECT_EQ(result.nodes, 6U);
  EXPECT_EQ(result.nodes_sound, 5U);
  EXPECT_EQ(result.nodes_pruned, 1U);
  EXPECT_EQ(result.pruned_text, "right");
  EXPECT_EQ(result.pruned.matching_states, result.tree.matching_states);
}

TEST_F(WindyScore, JsonHasTheSameFigures) {
  const Score result = score("right", {.episodes = 3, .steps = 4, .seed = 1});
  const auto json = nlohmann::json::parse(to_json(result));
  EXPECT_EQ(to_json(result).find('\n'), std::string::npos);
  EXPECT_EQ(json["world"], "windy");
  EXPECT_EQ(json["tree"]["agreement"]["mean"], 0.5);
  EXPECT_EQ(json["tree"]["matching_states"], 2);
  EXPECT_EQ(json["policy"]["agreement_over_states"], 1.0);
  EXPECT_EQ(json["nodes"]["tree"], 1);
}

TEST_F(WindyScore, TextHasColumnsThatNeverTouch) {
  const Score result = score("right", {.episodes = 3, .steps = 4, .seed = 1});
  const std::string text = to_text(result);
  EXPECT_NE(text.find("agreement over all states  100.0 %"), std::string::npos) << text;
  EXPECT_NE(text.find("50.0 % +- 0.0"), std::string::npos) << text;
  EXPECT_NE(text.find("12 entries"), std::string::npos) << text;
  EXPECT_EQ(text.find("3123"), std::string::npos) << text;
  Score room = result;
  room.thesis_room = true;
  EXPECT_NE(to_text(room).find("| 3123 entries  6 nodes  20 nodes"), std::string::npos) << to_text(room);
}

TEST_F(WindyScore, WhatIsExpectedAlongTheChainIsAddedWhenAsked) {
  Score result = score("right", {.episodes = 3, .steps = 4, .seed = 1});
  EXPECT_EQ(to_text(result).find("along the chain"), to_text(result).npos);
  EXPECT_FALSE(nlohmann::json::parse(to_json(result)).contains("exact"));
  add_exact(chain_, *parse_tree("right", chain_.vocabulary()), result);
  ASSERT_TRUE(result.expected.has_value());
  // Nothing was tried: after the first step a third of the walks is in each state, in two of which the tree agrees.
  EXPECT_NEAR(result.expected->tree.agreement, (1.0 + 3.0 * 2.0 / 3.0) / 4.0, 1e-15);
  EXPECT_NEAR(result.expected->policy.agreement, 1.0, 1e-15);
  EXPECT_EQ(result.expected->tree.reward, 0.0);
  EXPECT_NE(to_text(result).find("75.000 % exactly"), std::string::npos) << to_text(result);
  EXPECT_NEAR(nlohmann::json::parse(to_json(result))["exact"]["tree"]["agreement"].get<double>(), 0.75, 1e-15);
}

TEST_F(WindyScore, StopsBetweenEpisodes) {
  int asked = 0;
  const auto stopped = score_tree(world_, chain_, Tree(ActionId{0}), {.episodes = 50, .steps = 4, .seed = 1},
                                  [&] { return ++asked < 60; });
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().kind, ErrorKind::interrupted);
  EXPECT_EQ(asked, 60);
}

TEST_F(WindyScore, SettingsOutOfRangeAndAForeignWorldAreBadInput) {
  const Tree tree(ActionId{0});
  const auto none = score_tree(world_, chain_, tree, {.episodes = 1, .steps = 4, .seed = 1});  // gives no interval
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().kind, ErrorKind::bad_input);
  EXPECT_NE(none.error().message.find("--episodes"), std::string::npos);
  const auto long_walk = score_tree(world_, chain_, tree, {.episodes = 2, .steps = 1'000'001, .seed = 1});
  ASSERT_FALSE(long_walk);
  EXPECT_NE(long_walk.error().message.find("--steps"), std::string::npos);
  const auto room = load_world("uav");
  ASSERT_TRUE(room);
  EXPECT_FALSE(score_tree(*room, chain_, tree, {}));
}

}  // namespace
}  // namespace coppice
