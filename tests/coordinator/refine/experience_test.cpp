#include "coordinator/refine/experience.hpp"

#include <gtest/gtest.h>
#include <map>
#include <tuple>

#include "common/chain/chain_bytes.hpp"
#include "common/tree/text.hpp"
#include "coordinator/learning/learn.hpp"
#include "coordinator/learning/uav_room.hpp"
#include "tests/coordinator/evolution/small_world.hpp"
#include "tests/coordinator/learning/rooms.hpp"

namespace coppice {
namespace {

using Observation = std::string;  // a byte a feature
// (before, action, after) -> count; (before, action) -> reward
using Counts = std::map<std::tuple<Observation, std::size_t, Observation>, std::uint64_t>;
using Rewards = std::map<std::pair<Observation, std::size_t>, double>;

Observation seen(std::span<const std::uint8_t> features) { return {features.begin(), features.end()}; }

// Everything that a chain counted, by what was observed instead of by state.
Counts counts_of(const Chain& chain) {
  Counts counts;
  for (std::size_t state = 0; state < chain.states(); ++state) {
    for (std::size_t action = 0; action < chain.actions(); ++action) {
      const std::size_t row = chain.row(state, ActionId{static_cast<std::uint8_t>(action)});
      for (std::size_t i = 0; i < chain.successors(row).size(); ++i) {
        counts[{seen(chain.features_of(state)), action, seen(chain.features_of(chain.successors(row)[i]))}] =
            chain.counts(row)[i];
      }
    }
  }
  return counts;
}

Rewards rewards_of(const Chain& chain) {
  Rewards rewards;
  for (std::size_t state = 0; state < chain.states(); ++state) {
    for (std::size_t action = 0; action < chain.actions(); ++action) {
      rewards[{seen(chain.features_of(state)), action}] = chain.parts().reward_sum[state * chain.actions() + action];
    }
  }
  return rewards;
}

// A chain that knows little of the room, so that there is something to meet.
Chain little_learned(const World& world) {
  LearnSettings settings = default_settings(WorldKind::uav, Algorithm::q_learning);
  settings.episodes = 3;
  settings.steps = 20;
  return std::move(learn(world, settings, {})->chain);
}

Tree wall_tree(const Chain& chain) {
  return parse_tree("(selector (sequence s3=0 turn_left) (sequence s5=3 turn_right) move)", chain.vocabulary()).value();
}

// Against sums made here from the very steps that the simulator showed.
TEST(Experience, AddsExactlyTheStepsThatWereTakenAndChangesNothingElse) {
  const World world = testing::world(testing::small_room());
  const Chain chain = little_learned(world);
  Experience experience(chain);
  Counts counts = counts_of(chain);
  Rewards rewards = rewards_of(chain);
  std::uint64_t steps = 0;
  simulate_tree(world, chain, wall_tree(chain), {.episodes = 40, .steps = 60, .seed = 3}, {},
                [&](const SimulatedStep& step) {
                  experience.add(step);
                  ++counts[{seen(step.before), index_of(step.action), seen(step.after)}];
                  rewards[{seen(step.before), index_of(step.action)}] += step.reward;
                  ++steps;
                });
  EXPECT_EQ(steps, 40U * 60U);
  const auto extended = experience.extended();
  ASSERT_TRUE(extended.has_value()) << extended.error().message;
  EXPECT_EQ(counts_of(extended->chain), counts);
  for (const auto& [pair, reward] : rewards_of(extended->chain)) {
    EXPECT_EQ(reward, rewards[pair]);
  }
  const Gains& gains = extended->gains;
  EXPECT_EQ(gains.steps, steps);
  EXPECT_EQ(gains.states, extended->chain.states() - chain.states());
  EXPECT_EQ(gains.transitions, counts.size() - counts_of(chain).size());
  EXPECT_GT(gains.states, 0U) << "the test needs a room that learning knows little of";
  EXPECT_GE(gains.pairs, gains.states - 1) << "only where the last step led nothing was tried";
  EXPECT_NE(hash_of(to_bytes(extended->chain)), hash_of(to_bytes(chain)));
}

TEST(Experience, LeavesWhatLearningMadeOfKnownStates) {
  const World world = testing::world(testing::small_room());
  const Chain chain = little_learned(world);
  Experience experience(chain);
  simulate_tree(world, chain, wall_tree(chain), {.episodes = 9, .steps = 60, .seed = 3}, {},
                [&](const SimulatedStep& step) { experience.add(step); });
  const Extended extended = experience.extended().value();
  EXPECT_EQ(extended.chain.initial_state(), chain.initial_state());
  for (std::size_t state = 0; state < chain.states(); ++state) {
    EXPECT_EQ(seen(extended.chain.features_of(state)), seen(chain.features_of(state)));
    EXPECT_EQ(extended.chain.policy(state), chain.policy(state));
    EXPECT_EQ(extended.chain.parts().visits[state], chain.parts().visits[state]);
    for (std::size_t action = 0; action < 3; ++action) {
      EXPECT_EQ(extended.chain.parts().q[state * 3 + action], chain.parts().q[state * 3 + action]);
    }
  }
  for (std::size_t state = chain.states(); state < extended.chain.states(); ++state) {
    EXPECT_EQ(extended.chain.policy(state), ActionId{0}) << "greedy on a row of zeros, as the simulated policy";
    EXPECT_EQ(extended.chain.parts().visits[state], 0U);
  }
}

TEST(Experience, NothingMetIsTheSameChain) {
  const Chain chain = testing::small_chain();
  const Extended same = Experience(chain).extended().value();
  EXPECT_EQ(same.chain.parts(), chain.parts());
  EXPECT_EQ(same.gains, Gains{});
}

TEST(Experience, CountsCollisionsWhereTheChainDoesAndRefusesASimulatorThatDoesNotSay) {
  ChainParts parts = testing::small_chain().parts();
  parts.collisions.assign(parts.reward_sum.size(), 0);
  const Chain chain = *Chain::make(std::move(parts));
  const std::vector<std::uint8_t> seen(chain.features_of(0).begin(), chain.features_of(0).end());
  const auto step = [&](std::optional<bool> collided) {
    return SimulatedStep{
        .before = seen, .action = ActionId{1}, .reward = -1.0, .after = seen, .ended = false, .collided = collided};
  };
  Experience experience(chain);
  for (const bool collided : {true, false, true}) {
    experience.add(step(collided));
  }
  const Extended extended = experience.extended().value();
  std::vector<std::uint32_t> expected(chain.states() * chain.actions(), 0);
  expected[chain.row(0, ActionId{1})] = 2;
  EXPECT_EQ(extended.chain.parts().collisions, expected);
  experience.add(step(std::nullopt));
  EXPECT_TRUE(experience.lacks_collisions());
  ASSERT_FALSE(experience.extended().has_value());
  EXPECT_NE(experience.extended().error().message.find("--collision-reward"), std::string::npos);

  const Chain silent = testing::small_chain();  // nobody said what collides: none is counted, and none is missed
  Experience without(silent);
  without.add(step(std::nullopt));
  EXPECT_TRUE(without.extended().value().chain.parts().collisions.empty());
}

// In what order steps are met decides the numbers of new states, nothing else.
TEST(Experience, IsCountedTheSameWhenAddedInTwoParts) {
  const World world = testing::world(testing::small_room());
  const Chain chain = little_learned(world);
  const auto walk = [&](const Chain& known, std::uint64_t first, std::uint64_t episodes) {
    Experience experience(known);
    simulate_tree(world, known, wall_tree(known),
                  {.episodes = episodes, .steps = 50, .seed = 8, .first_episode = first}, {},
                  [&](const SimulatedStep& step) { experience.add(step); });
    return experience.extended().value();
  };
  const Extended whole = walk(chain, 0, 12);
  const Extended half = walk(chain, 0, 7);
  EXPECT_EQ(walk(half.chain, 7, 5).chain.parts(), whole.chain.parts());
}

TEST(Experience, RefusesWhatAChainCannotCount) {
  ChainParts parts = testing::small_chain().parts();
  std::size_t row = 0;
  while (parts.row_begin[row] == parts.row_begin[row + 1]) {
    ++row;
  }
  for (std::uint64_t i = parts.row_begin[row]; i < parts.row_begin[row + 1]; ++i) {
    parts.count[i] = 1;
  }
  parts.count[parts.row_begin[row]] =
      0xFFFFFFFF - static_cast<std::uint32_t>(parts.row_begin[row + 1] - parts.row_begin[row] - 1);
  const Chain full = Chain::make(parts).value();
  Experience experience(full);
  experience.add({.before = full.features_of(row / 3),
                  .action = ActionId{static_cast<std::uint8_t>(row % 3)},
                  .reward = 1.0,
                  .after = full.features_of(full.successors(row)[0])});
  const auto extended = experience.extended();
  ASSERT_FALSE(extended.has_value());
  EXPECT_EQ(extended.error().kind, ErrorKind::bad_input);
}

// Two states that look alike, a state that ends episodes and looks like neither, nothing else.
Chain with_look_alikes() {
  ChainParts parts;
  parts.vocabulary = {{{"x", {0, 1, 2}}}, {"go"}};
  parts.features = {0, 0, 1};
  parts.row_begin = {0, 1, 2, 3};
  parts.successor = {1, 2, 2};
  parts.count = {1, 1, 1};
  parts.reward_sum = {1.0, 1.0, 0.0};
  parts.q = {0.0, 0.0, 0.0};
  parts.policy = {ActionId{0}, ActionId{0}, ActionId{0}};
  parts.visits = {1, 1, 1};
  parts.look_alikes = true;
  parts.terminals = {2};
  return *Chain::make(std::move(parts));
}

TEST(Experience, numbers_new_states_behind_all_others_where_some_look_alike) {
  const Chain chain = with_look_alikes();
  Experience experience(chain);
  const std::vector<std::uint8_t> alike = {0};
  const std::vector<std::uint8_t> fresh = {2};
  experience.add({.before = alike, .action = ActionId{0}, .reward = 1.0, .after = fresh});
  const Result<Extended> extended = experience.extended();
  ASSERT_TRUE(extended) << extended.error().message;
  EXPECT_EQ(extended->chain.states(), 4U);
  EXPECT_EQ(extended->gains, (Gains{.steps = 1, .states = 1, .pairs = 0, .transitions = 1}));
  EXPECT_EQ(extended->chain.tries(0), 2U);
}

TEST(Experience, leads_a_step_that_ends_an_episode_to_a_state_that_does_and_never_goes_on_from_one) {
  const Chain chain = with_look_alikes();
  Experience experience(chain);
  const std::vector<std::uint8_t> alike = {0};
  const std::vector<std::uint8_t> end = {1};
  experience.add({.before = alike, .action = ActionId{0}, .reward = 0.0, .after = end, .ended = true});
  experience.add({.before = end, .action = ActionId{0}, .reward = 0.0, .after = alike});  // it looked so, and went on
  const Result<Extended> extended = experience.extended();
  ASSERT_TRUE(extended) << extended.error().message;
  EXPECT_EQ(extended->chain.states(), 4U);
  EXPECT_EQ(extended->chain.successors(0)[1], 2U);
  EXPECT_EQ(extended->chain.tries(2), 1U);
  EXPECT_EQ(extended->chain.tries(3), 1U);
}

}  // namespace
}  // namespace coppice
