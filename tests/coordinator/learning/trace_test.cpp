// What is watched is what was scored, and where the agent stands follows from the rules of the world.
#include "coordinator/learning/trace.hpp"

#include <gtest/gtest.h>

#include "common/tree/text.hpp"
#include "coordinator/learning/learn.hpp"
#include "tests/coordinator/learning/rooms.hpp"

namespace coppice {
namespace {

struct Case {
  World world;
  Chain chain;
};

Case learned_in(const World& world) {
  LearnSettings settings = default_settings(world.kind, Algorithm::q_learning);
  settings.episodes = 300;
  settings.steps = 60;
  return {world, std::move(learn(world, settings, {})->chain)};
}

constexpr SimulateSettings kSettings{.episodes = 20, .steps = 60, .seed = 3};

void expect_same(const std::vector<Trace>& traces, const std::vector<EpisodeRecord>& records) {
  ASSERT_EQ(traces.size(), records.size());
  for (std::size_t i = 0; i < traces.size(); ++i) {
    double reward = 0.0;
    std::uint32_t collisions = 0;
    for (const TracedStep& step : traces[i].steps) {
      reward += step.reward;
      collisions += step.collided ? 1U : 0U;
    }
    EXPECT_EQ(traces[i].steps.size(), records[i].steps);
    EXPECT_EQ(reward, records[i].reward);
    EXPECT_EQ(collisions, records[i].collisions);
  }
}

TEST(Trace, OfTreeAndPolicyIsTheEpisodeThatIsScored) {
  for (const World& world : {testing::world(testing::small_room()), *load_world("windy"), *load_world("battery")}) {
    const Case learned = learned_in(world);
    expect_same(*trace_episodes(world, learned.chain, nullptr, kSettings),
                *simulate_policy(world, learned.chain, kSettings));
    const Tree tree(ActionId{0});
    expect_same(*trace_episodes(world, learned.chain, &tree, kSettings),
                *simulate_tree(world, learned.chain, tree, kSettings));
  }
}

TEST(Trace, StandsOnFloorMovesOneCellAndTrashOnlyMoves) {
  const Case learned = learned_in(testing::world(testing::small_room()));
  const std::optional<Grid> grid = grid_of(learned.world);
  ASSERT_TRUE(grid && grid->has_heading);
  const auto traces = trace_episodes(learned.world, learned.chain, nullptr, kSettings);
  for (const Trace& trace : *traces) {
    Pose at = trace.start;
    std::vector<Cell> cells = grid->cells;
    for (const TracedStep& step : trace.steps) {
      EXPECT_NE(cells[step.after.cell], Cell::wall);
      const auto column = [&](const Pose& pose) { return static_cast<int>(pose.cell % grid->width); };
      const auto row = [&](const Pose& pose) { return static_cast<int>(pose.cell / grid->width); };
      const int moved = std::abs(column(at) - column(step.after)) + std::abs(row(at) - row(step.after));
      EXPECT_LE(moved, 1);
      EXPECT_FALSE(step.collided && moved > 0);
      EXPECT_EQ(step.trash_moved_to.has_value(), step.reward == 20.0);
      if (step.trash_moved_to) {
        EXPECT_EQ(cells[step.after.cell], Cell::trash);
        cells[step.after.cell] = Cell::free;
        EXPECT_EQ(cells[*step.trash_moved_to], Cell::free);
        cells[*step.trash_moved_to] = Cell::trash;
      }
      at = step.after;
    }
  }
}

TEST(Trace, StopsBetweenEpisodesWhenToldTo) {
  const Case learned = learned_in(testing::world(testing::small_room()));
  int asked = 0;
  const auto traces = trace_episodes(learned.world, learned.chain, nullptr, kSettings, [&] { return ++asked < 3; });
  ASSERT_FALSE(traces);
  EXPECT_EQ(traces.error().kind, ErrorKind::interrupted);
}

TEST(LearningCurve, IsTheMeanOfAllEpisodesGroupByGroup) {
  const World world = testing::world(testing::small_room());
  LearnSettings settings = default_settings(world.kind, Algorithm::q_learning);
  settings.episodes = 1050;  // 175 groups of 6: more episodes than points, and none left over
  settings.steps = 30;
  const auto learned = learn(world, settings, {});
  const LearningCurve& curve = learned->curve;
  EXPECT_EQ(curve.episodes_per_point, 6U);
  ASSERT_EQ(curve.reward.size(), 175U);
  double collisions = 0.0;
  for (const double mean : curve.collisions) {
    collisions += mean * 6.0;
  }
  EXPECT_NEAR(collisions, static_cast<double>(learned->collisions), 1e-6);
  settings.episodes = 5;
  EXPECT_EQ(learn(world, settings, {})->curve.reward.size(), 5U);
}

}  // namespace
}  // namespace coppice
