// Chapter 4: both algorithms converge, and what follows the way is told from what does not.
#include "coordinator/reproduce/grid_tables.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "common/tree/text.hpp"
#include "coordinator/learning/windy_grid.hpp"

namespace coppice {
namespace {

TEST(Grid, BothAlgorithmsConvergeAndFindAWayOfFifteenSteps) {
  for (const Algorithm algorithm : {Algorithm::q_learning, Algorithm::sarsa}) {
    const auto found = learn_grid(algorithm, 1);
    ASSERT_TRUE(found);
    EXPECT_TRUE(found->arrives);
    EXPECT_EQ(found->steps, 15U);
    EXPECT_EQ(found->reward, -5.0);
    EXPECT_EQ(greedy_way(found->learned.chain).size(), 15U);
    const LearnSettings settings = grid_settings(algorithm, 1);
    const std::uint64_t episode = converged_in(found->learned, settings);
    EXPECT_GT(episode, 0U);
    EXPECT_LT(found->learned.largest_change, kConvergedChange);
    // SARSA values its own exploration, so it moves as long as there is some.
    EXPECT_EQ(episode > settings.episodes, algorithm == Algorithm::sarsa);
  }
}

TEST(Grid, WithoutGreedyEpisodesSarsaHasNotConverged) {
  LearnSettings settings = grid_settings(Algorithm::sarsa, 1);
  settings.greedy_episodes = 0;
  const auto learned = learn({WorldKind::windy, ""}, settings, {});
  ASSERT_TRUE(learned);
  EXPECT_EQ(learned->last_change_episode, settings.episodes);
  EXPECT_EQ(converged_in(*learned, settings), 0U);
}

TEST(Grid, ATreeIsPrunedToWhatTheWayNeeds) {
  const auto policy = learn_grid(Algorithm::q_learning, 1);
  ASSERT_TRUE(policy && policy->arrives);
  const Chain& chain = policy->learned.chain;
  std::string text = "(selector";
  for (const std::size_t state : greedy_way(chain)) {
    text += fmt::format(" (sequence x={} y={} {})", chain.features_of(state)[0], chain.features_of(state)[1],
                        chain.vocabulary().actions[index_of(chain.policy(state))]);
  }
  const Tree tree = *parse_tree(text + ")", chain.vocabulary());
  const GridTree pruned = on_the_way(tree, 1, chain);
  EXPECT_TRUE(pruned.follows);
  EXPECT_LT(pruned.tree.size(), tree.size());
  EXPECT_FALSE(on_the_way(Tree(ActionId{0}), 1, chain).follows);
}

}  // namespace
}  // namespace coppice
