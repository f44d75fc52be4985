// Interrupted between any two episodes, saved and restored, learning comes to the same bits.
#include "coordinator/learning/learning_loop.hpp"

#include <gtest/gtest.h>
#include <numeric>

#include "common/chain/chain_bytes.hpp"
#include "tests/coordinator/learning/rooms.hpp"

namespace coppice {
namespace {

using testing::room;
using testing::small_room;

constexpr std::uint64_t kEpisodes = 300;

LearnSettings settings_for(WorldKind kind, Algorithm algorithm) {
  LearnSettings settings = default_settings(kind, algorithm);
  settings.episodes = kEpisodes - 20;
  settings.greedy_episodes = 20;
  settings.steps = 120;
  return settings;
}

BatteryRoom battery_simulator() { return BatteryRoom(room({"######", "#^*.C#", "#..*.#", "#>##.#", "######"})); }

template <typename Loop, typename Simulator>
void expect_same_when_interrupted(const Simulator& simulator, const LearnSettings& settings) {
  const auto whole = Loop(simulator, settings).run({});
  ASSERT_TRUE(whole.has_value());
  for (const std::uint64_t at : {std::uint64_t{0}, std::uint64_t{1}, std::uint64_t{137}, kEpisodes - 1, kEpisodes}) {
    Loop first(simulator, settings);
    first.advance(at);
    const LearnCheckpoint saved = first.save();
    EXPECT_EQ(saved.episodes_done, at);
    Loop second(simulator, settings);
    ASSERT_TRUE(second.restore(saved).has_value()) << at;
    const auto resumed = second.run({});
    ASSERT_TRUE(resumed.has_value()) << at;
    EXPECT_EQ(to_bytes(resumed->chain), to_bytes(whole->chain)) << at;
    EXPECT_EQ(resumed->curve.reward, whole->curve.reward) << at;
    EXPECT_EQ(resumed->curve.collisions, whole->curve.collisions) << at;
    EXPECT_EQ(resumed->steps, whole->steps) << at;
    EXPECT_EQ(resumed->last_rewards, whole->last_rewards) << at;
    EXPECT_EQ(resumed->largest_change, whole->largest_change) << at;
    EXPECT_EQ(resumed->last_change_episode, whole->last_change_episode) << at;
    EXPECT_EQ(resumed->last_collision_episode, whole->last_collision_episode) << at;
  }
}

TEST(LearningLoop, AnInterruptionChangesNoBit) {
  expect_same_when_interrupted<LearningLoop<UavRoom, Algorithm::q_learning>>(
      UavRoom(room(small_room())), settings_for(WorldKind::uav, Algorithm::q_learning));
  expect_same_when_interrupted<LearningLoop<WindyGrid, Algorithm::sarsa>>(
      WindyGrid(), settings_for(WorldKind::windy, Algorithm::sarsa));
  expect_same_when_interrupted<LearningLoop<BatteryRoom, Algorithm::sarsa>>(
      battery_simulator(), settings_for(WorldKind::battery, Algorithm::sarsa));
}

TEST(LearningLoop, ADamagedOrForeignStateIsRefused) {
  using Loop = LearningLoop<BatteryRoom, Algorithm::q_learning>;
  const LearnSettings settings = settings_for(WorldKind::battery, Algorithm::q_learning);
  Loop loop(battery_simulator(), settings);
  loop.advance(50);
  const LearnCheckpoint saved = loop.save();
  for (std::size_t size = 0; size < saved.state.size(); size += 97) {
    LearnCheckpoint cut{saved.episodes_done, {saved.state.begin(), saved.state.begin() + static_cast<long>(size)}};
    EXPECT_FALSE(Loop(battery_simulator(), settings).restore(cut).has_value()) << size;
  }
  EXPECT_FALSE(Loop(battery_simulator(), settings).restore({saved.episodes_done + 1, saved.state}).has_value());
  EXPECT_FALSE((LearningLoop<WindyGrid, Algorithm::q_learning>(WindyGrid(), settings).restore(saved).has_value()));
}

TEST(LearningLoop, EveryStartIsMetAndCountedInTheChain) {
  const auto learned = LearningLoop<BatteryRoom, Algorithm::q_learning>(
                           battery_simulator(), settings_for(WorldKind::battery, Algorithm::q_learning))
                           .run({});
  ASSERT_TRUE(learned.has_value());
  const auto starts = learned->chain.starts();
  ASSERT_EQ(starts.size(), 2U);
  EXPECT_EQ(starts[0].count + starts[1].count, kEpisodes);
  EXPECT_EQ(learned->chain.starts_total(), kEpisodes);
  // Each is drawn with a half: 5 standard deviations of a binomial distribution are 43.
  EXPECT_NEAR(static_cast<double>(starts[0].count), 150.0, 43.0);
}

TEST(LearningLoop, CountsTheCollisionsOfEachPairWhereTheWorldSaysSo) {
  const auto learned = LearningLoop<BatteryRoom, Algorithm::q_learning>(
                           battery_simulator(), settings_for(WorldKind::battery, Algorithm::q_learning))
                           .run({});
  ASSERT_TRUE(learned.has_value());
  const std::vector<std::uint32_t>& collisions = learned->chain.parts().collisions;
  EXPECT_EQ(std::accumulate(collisions.begin(), collisions.end(), std::uint64_t{0}), learned->collisions);
  EXPECT_GT(learned->collisions, 0U);
}

}  // namespace
}  // namespace coppice
