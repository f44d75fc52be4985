// Events as text, and as pairs of a chain.
#include "coordinator/trust/events.hpp"

#include <gtest/gtest.h>

#include "coordinator/learning/learn.hpp"

namespace coppice {
namespace {

TEST(Event, IsATestOfTheReward) {
  const auto event = parse_event("crash:reward<=-10.5");
  ASSERT_TRUE(event) << event.error().message;
  EXPECT_EQ(event->name, "crash");
  EXPECT_TRUE(event->at_most);
  EXPECT_EQ(event->bound, -10.5);
  EXPECT_EQ(to_text(*event), "reward<=-10.5");
  for (const char* wrong : {"", "crash", ":reward<=1", "crash:reward=1", "crash:reward<=", "crash:reward<=x",
                            "crash:reward<=1x", "crash:reward<=nan", "crash:Reward>=1", "crash: reward>=1"}) {
    EXPECT_FALSE(parse_event(wrong)) << wrong;
  }
}

TEST(Event, InTheRoomTheRewardTellsWhatTheSensorsSay) {
  const auto world = load_world("uav");
  ASSERT_TRUE(world);
  LearnSettings settings = default_settings(WorldKind::uav, Algorithm::q_learning);
  settings.episodes = 2000;
  const auto learned = learn(*world, settings, {});
  ASSERT_TRUE(learned);
  const Chain& chain = learned->chain;
  const auto events = events_of_world("uav");
  ASSERT_EQ(events.size(), 2U);
  const auto rewards = rewards_of_world("uav");
  const EventPairs collision = pairs_of(events[0], chain, rewards);
  const EventPairs trash = pairs_of(events[1], chain, rewards);
  EXPECT_EQ(collision.unclear, 0U);
  EXPECT_GT(collision.pairs, 10U);
  EXPECT_GT(trash.pairs, 10U);
  for (std::size_t state = 0; state < chain.states(); ++state) {
    for (std::size_t action = 0; action < 3; ++action) {
      const bool moves = action == 0 && chain.tries(state * 3 + action) > 0;
      EXPECT_EQ(collision.chance[state * 4 + action] > 0.0, moves && chain.features_of(state)[3] == 0);
      EXPECT_EQ(trash.chance[state * 4 + action] > 0.0, moves && chain.features_of(state)[3] == 3);
    }
    EXPECT_EQ(collision.chance[state * 4 + 3], 0.0);
  }
}

}  // namespace
}  // namespace coppice
