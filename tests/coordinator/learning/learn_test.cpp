#include "coordinator/learning/learn.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <numeric>
#include <vector>

#include "coordinator/learning/simulate.hpp"
#include "coordinator/learning/uav_room.hpp"
#include "tests/coordinator/learning/rooms.hpp"

namespace coppice {
namespace {

using testing::small_room;

LearnSettings quick(Algorithm algorithm) {
  LearnSettings settings = default_settings(WorldKind::uav, algorithm);
  settings.episodes = 400;
  settings.steps = 60;
  return settings;
}

Learned learned(const World& world, const LearnSettings& settings) {
  auto result = learn(world, settings, {});
  EXPECT_TRUE(result.has_value()) << result.error().message;
  return std::move(*result);
}

// Steps to the goal on the shortest way, from the rules of the windy grid alone.
std::uint32_t shortest_way() {
  constexpr std::array kWind{0, 0, 0, 1, 1, 1, 2, 2, 1, 0};
  constexpr std::array<std::array<int, 2>, 4> kMoves{{{0, 1}, {0, -1}, {1, 0}, {-1, 0}}};
  std::array<std::array<int, 8>, 10> distance{};
  std::vector<std::array<int, 2>> queue{{0, 3}};
  distance[0][3] = 1;
  for (std::size_t head = 0; head < queue.size(); ++head) {
    const auto [x, y] = queue[head];
    const int so_far = distance[static_cast<std::size_t>(x)][static_cast<std::size_t>(y)];
    if (x == 7 && y == 3) {
      return static_cast<std::uint32_t>(so_far - 1);
    }
    for (const auto& move : kMoves) {
      const int to_x = std::min(9, std::max(0, x + move[0]));
      const int to_y = std::min(7, std::max(0, y + move[1] - kWind[static_cast<std::size_t>(x)]));
      int& there = distance[static_cast<std::size_t>(to_x)][static_cast<std::size_t>(to_y)];
      if (there == 0) {
        there = so_far + 1;
        queue.push_back({to_x, to_y});
      }
    }
  }
  return 0;
}

TEST(LearnSettings, DefaultsAreTheThesisTables) {
  const LearnSettings uav = default_settings(WorldKind::uav, Algorithm::q_learning);
  EXPECT_EQ(uav.episodes, 1'000'000U);
  EXPECT_EQ(uav.steps, 150U);
  EXPECT_EQ(uav.alpha, 0.5);
  EXPECT_EQ(uav.gamma, 0.8);
  EXPECT_EQ(uav.epsilon, 0.5);
  EXPECT_EQ(uav.decay, Decay::thesis);
  const LearnSettings windy = default_settings(WorldKind::windy, Algorithm::q_learning);
  EXPECT_EQ(windy.steps, 25U);
  EXPECT_EQ(windy.alpha, 0.3);
  EXPECT_EQ(windy.gamma, 0.8);
  EXPECT_EQ(windy.decay, Decay::linear);
  EXPECT_EQ(default_settings(WorldKind::windy, Algorithm::sarsa).gamma, 0.9);
}

TEST(LearnSettings, ExplorationDecaysByItsFormula) {
  LearnSettings settings;  // Table II
  EXPECT_DOUBLE_EQ(exploration(settings, 1), 0.5);
  EXPECT_NEAR(exploration(settings, 1'000'000), 0.00495, 5e-6);
  EXPECT_DOUBLE_EQ(exploration(settings, 40'000), 0.5 * 10'001.0 / 50'000.0);
  settings.decay = Decay::printed;
  EXPECT_NEAR(exploration(settings, 1), 0.50005, 1e-9);
  EXPECT_NEAR(exploration(settings, 1'000'000), 5e-7, 1e-10);
  settings.decay = Decay::linear;
  EXPECT_DOUBLE_EQ(exploration(settings, 1), 0.5);
  EXPECT_EQ(exploration(settings, 1'000'000), 0.0);
}

TEST(LearnSettings, ExplorationIsAlwaysAProbability) {
  for (const Decay decay : {Decay::thesis, Decay::printed, Decay::linear}) {
    for (const std::uint64_t episodes : {1U, 2U, 50U, 1000U}) {
      LearnSettings settings;
      settings.decay = decay;
      settings.episodes = episodes;
      settings.epsilon = 1.0;
      for (std::uint64_t k = 1; k <= episodes; ++k) {
        EXPECT_GE(exploration(settings, k), 0.0);
        EXPECT_LE(exploration(settings, k), 1.0);
      }
    }
  }
}

TEST(LearnSettings, NamesGoThereAndBack) {
  for (const Algorithm algorithm : {Algorithm::q_learning, Algorithm::sarsa}) {
    EXPECT_EQ(value_named<Algorithm>("algorithm", name_of(algorithm)), algorithm);
  }
  for (const Decay decay : {Decay::thesis, Decay::printed, Decay::linear}) {
    EXPECT_EQ(value_named<Decay>("decay", name_of(decay)), decay);
  }
  EXPECT_FALSE(value_named<Algorithm>("algorithm", "dqn").has_value());
  EXPECT_FALSE(value_named<Decay>("decay", "").has_value());
}

TEST(LearnSettings, BadOnesAreRefusedByFlag) {
  const auto refused = [](const char* flag, const auto& change) {
    LearnSettings settings;
    change(settings);
    const auto result = check_settings(settings);
    ASSERT_FALSE(result.has_value()) << flag;
    EXPECT_EQ(result.error().kind, ErrorKind::bad_input);
    EXPECT_EQ(result.error().message.find(flag), 0U) << result.error().message;
    EXPECT_FALSE(learn(testing::world(small_room()), settings, {}).has_value());
  };
  EXPECT_TRUE(check_settings(LearnSettings{}).has_value());
  refused("--episodes", [](LearnSettings& s) { s.episodes = 0; });
  refused("--episodes", [](LearnSettings& s) { s.episodes = std::numeric_limits<std::uint64_t>::max(); });
  refused("--steps", [](LearnSettings& s) { s.steps = 0; });
  refused("--steps", [](LearnSettings& s) { s.steps = 5000; });  // a million times 5000 overflows a count
  refused("--alpha", [](LearnSettings& s) { s.alpha = 0.0; });
  refused("--alpha", [](LearnSettings& s) { s.alpha = std::nan(""); });
  refused("--gamma", [](LearnSettings& s) { s.gamma = 1.01; });
  refused("--epsilon", [](LearnSettings& s) { s.epsilon = -0.1; });
}

TEST(Learn, ABadRoomIsAnError) {
  const auto result = learn(World{WorldKind::uav, "###\n#.#\n###\n"}, LearnSettings{}, {});
  ASSERT_FALSE(result.has_value());
  EXPECT_EQ(result.error().kind, ErrorKind::bad_input);
}

TEST(Learn, TheSameSeedGivesTheSameChainAndAnotherSeedAnother) {
  for (const Algorithm algorithm : {Algorithm::q_learning, Algorithm::sarsa}) {
    const World world = testing::world(small_room());
    LearnSettings settings = quick(algorithm);
    const Learned first = learned(world, settings);
    const Learned second = learned(world, settings);
    EXPECT_TRUE(first.chain.parts() == second.chain.parts());
    EXPECT_EQ(first.last_rewards, second.last_rewards);
    settings.seed = 2;
    EXPECT_FALSE(learned(world, settings).chain.parts() == first.chain.parts());
  }
}

TEST(Learn, CountsEveryStepOnce) {
  for (const Algorithm algorithm : {Algorithm::q_learning, Algorithm::sarsa}) {
    const LearnSettings settings = quick(algorithm);
    const Learned result = learned(testing::world(small_room()), settings);
    const ChainParts& parts = result.chain.parts();
    EXPECT_EQ(result.steps, settings.episodes * settings.steps);
    EXPECT_EQ(std::accumulate(parts.count.begin(), parts.count.end(), std::uint64_t{0}), result.steps);
    EXPECT_EQ(std::accumulate(parts.visits.begin(), parts.visits.end(), std::uint64_t{0}), result.steps);
    EXPECT_EQ(parts.policy, greedy_policy(parts.q, result.chain.actions()));
    for (std::size_t state = 0; state < result.chain.states(); ++state) {
      std::uint64_t tries = 0;
      for (std::size_t action = 0; action < result.chain.actions(); ++action) {
        tries += result.chain.tries(state * result.chain.actions() + action);
      }
      EXPECT_EQ(tries, parts.visits[state]);
    }
  }
}

// Whoever comes into a state acts there, but for the last step of each episode; each episode also starts once.
TEST(Learn, WhatFlowsIntoAStateFlowsOutOfIt) {
  const LearnSettings settings = quick(Algorithm::q_learning);
  const Learned result = learned(testing::world(small_room()), settings);
  const ChainParts& parts = result.chain.parts();
  std::vector<std::uint64_t> arrivals(result.chain.states(), 0);
  arrivals[0] = settings.episodes;
  for (std::size_t i = 0; i < parts.successor.size(); ++i) {
    arrivals[parts.successor[i]] += parts.count[i];
  }
  std::uint64_t stayed = 0;
  for (std::size_t state = 0; state < arrivals.size(); ++state) {
    ASSERT_GE(arrivals[state], parts.visits[state]);
    stayed += arrivals[state] - parts.visits[state];
  }
  EXPECT_EQ(stayed, settings.episodes);
}

TEST(Learn, StartsInStateZero) {
  const World world = testing::world(small_room());
  const Learned result = learned(world, quick(Algorithm::q_learning));
  EXPECT_EQ(result.chain.initial_state(), 0U);
  EXPECT_EQ(UavRoom::code_of(result.chain.features_of(0)), UavRoom(testing::room(small_room())).code());
  EXPECT_EQ(result.chain.vocabulary(), vocabulary_of(world));
}

TEST(Learn, RecordsTheRewardOfEachPair) {
  const LearnSettings settings = quick(Algorithm::q_learning);
  const Learned result = learned(testing::world(small_room()), settings);
  const Chain& chain = result.chain;
  std::uint64_t collisions = 0;
  for (std::size_t state = 0; state < chain.states(); ++state) {
    const auto features = chain.features_of(state);
    const std::size_t move = chain.row(state, ActionId{0});
    if (chain.tries(move) > 0) {
      EXPECT_EQ(chain.mean_reward(move), features[3] == 0 ? -10.0 : features[3] == 3 ? 20.0 : 0.0);
      collisions += features[3] == 0 ? chain.tries(move) : 0;
    }
    for (const ActionId turn : {ActionId{1}, ActionId{2}}) {
      if (chain.tries(chain.row(state, turn)) > 0) {
        EXPECT_EQ(chain.mean_reward(chain.row(state, turn)), -1.0);
      }
    }
  }
  EXPECT_EQ(result.collisions, collisions);
  EXPECT_GT(collisions, 0U);
  EXPECT_LE(result.last_collision_episode, settings.episodes);
}

// In a corridor of two cells the returns are known: with a piece of trash always in the other cell, the best that a
// UAV facing it can do is move (+20), turn twice (-2) and move again.
TEST(Learn, QLearningFindsTheValuesOfACorridor) {
  LearnSettings settings = quick(Algorithm::q_learning);
  settings.episodes = 3000;
  const Learned result = learned(testing::world({"####", "#>*#", "####"}), settings);
  const double gamma = settings.gamma;
  const double facing = (20.0 - gamma - gamma * gamma) / (1.0 - gamma * gamma * gamma);
  const Chain& chain = result.chain;
  EXPECT_EQ(chain.policy(0), ActionId{0});
  EXPECT_NEAR(chain.parts().q[chain.row(0, ActionId{0})], facing, 1e-9);
  EXPECT_NEAR(chain.parts().q[chain.row(0, ActionId{1})], -1.0 + gamma * (-1.0 + gamma * facing), 1.0);
  EXPECT_NEAR(result.largest_change, 0.0, 1e-9);
}

TEST(Learn, TheLastRewardsAreTheMeanOfTheLastEpisodes) {
  LearnSettings settings = quick(Algorithm::q_learning);
  settings.episodes = 50;
  const Learned result = learned(testing::world(small_room()), settings);
  const std::vector<double>& rewards = result.chain.parts().reward_sum;
  EXPECT_DOUBLE_EQ(result.last_rewards, std::accumulate(rewards.begin(), rewards.end(), 0.0) / 50.0);
}

TEST(Learn, ALearnedUavCollectsAndDoesNotCollide) {
  const World world = load_world("uav").value();
  LearnSettings settings;
  settings.episodes = 10'000;
  const Learned result = learned(world, settings);
  const auto records = simulate_policy(world, result.chain, {.episodes = 20, .steps = 150, .seed = 1}).value();
  double reward = 0.0;
  std::uint32_t collisions = 0;
  for (const EpisodeRecord& record : records) {
    reward += record.reward;
    collisions += record.collisions;
  }
  EXPECT_GT(reward / 20.0, 100.0);
  EXPECT_LE(collisions, 10U);
}

TEST(Learn, QLearningConvergesToTheShortestWayOnTheWindyGrid) {
  const World world = load_world("windy").value();
  const Learned result = learned(world, default_settings(WorldKind::windy, Algorithm::q_learning));
  EXPECT_LT(result.largest_change, 1e-8);
  const auto records = simulate_policy(world, result.chain, {.episodes = 1, .steps = 25, .seed = 1}).value();
  ASSERT_GT(shortest_way(), 0U);
  EXPECT_EQ(records[0].steps, shortest_way());
  EXPECT_EQ(records[0].reward, 10.0 - static_cast<double>(shortest_way()));
}

TEST(Learn, SarsaFindsTheGoalOnTheWindyGrid) {
  const World world = load_world("windy").value();
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    LearnSettings settings = default_settings(WorldKind::windy, Algorithm::sarsa);
    settings.seed = seed;
    const Learned result = learned(world, settings);
    const auto records = simulate_policy(world, result.chain, {.episodes = 1, .steps = 25, .seed = 1}).value();
    EXPECT_LE(records[0].steps, shortest_way() + 2) << "seed " << seed;
    EXPECT_EQ(records[0].reward, 10.0 - static_cast<double>(records[0].steps)) << "seed " << seed;
  }
}

TEST(Learn, GreedyEpisodesComeBehindTheOthersAndExploreNothing) {
  LearnSettings settings = default_settings(WorldKind::windy, Algorithm::sarsa);
  settings.greedy_episodes = 300;
  EXPECT_EQ(exploration(settings, settings.episodes + 1), 0.0);
  settings.decay = Decay::printed;
  EXPECT_EQ(exploration(settings, settings.episodes + 300), 0.0);
  settings.decay = Decay::linear;
  const World world{WorldKind::windy, ""};
  const auto learned = learn(world, settings, {});
  ASSERT_TRUE(learned);
  // Without exploration SARSA comes to rest, some time after the last episode that explored.
  EXPECT_GT(learned->last_change_episode, settings.episodes);
  EXPECT_LT(learned->last_change_episode, settings.episodes + 300);
  EXPECT_LT(learned->largest_change, kConvergedChange);
  settings.greedy_episodes = ~std::uint64_t{0};
  EXPECT_FALSE(check_settings(settings));
}

TEST(Learn, SarsaAndQLearningDisagreeWhileTheyExplore) {
  const World world = testing::world(small_room());
  const Learned q = learned(world, quick(Algorithm::q_learning));
  const Learned sarsa = learned(world, quick(Algorithm::sarsa));
  EXPECT_NE(q.chain.parts().q, sarsa.chain.parts().q);
}

// The goal is never acted in: it is no state, and the step into it leads back to the start.
TEST(Learn, AnEndedEpisodeRenewsItself) {
  const Learned result =
      learned(load_world("windy").value(), default_settings(WorldKind::windy, Algorithm::q_learning));
  const Chain& chain = result.chain;
  EXPECT_LT(result.steps, 2000U * 25U);
  std::uint64_t renewals = 0;
  for (std::size_t state = 0; state < chain.states(); ++state) {
    const auto features = chain.features_of(state);
    EXPECT_FALSE(features[0] == 7 && features[1] == 3);
    for (std::size_t action = 0; action < chain.actions(); ++action) {
      const std::size_t row = state * chain.actions() + action;
      if (chain.tries(row) > 0 && chain.mean_reward(row) == 9.0) {
        ASSERT_EQ(chain.successors(row).size(), 1U);
        EXPECT_EQ(chain.successors(row)[0], 0U);
        EXPECT_NEAR(chain.parts().q[row], 9.0 * (1.0 - std::pow(0.7, static_cast<double>(chain.tries(row)))), 1e-9)
            << "the goal has no future";
        renewals += chain.tries(row);
      }
    }
  }
  EXPECT_GT(renewals, 100U);
}

TEST(Learn, StopsWhenProgressSaysSo) {
  LearnSettings settings;
  settings.steps = 60;
  settings.episodes = 70'000'000;
  std::uint64_t calls = 0;
  std::uint64_t episodes_done = 0;
  const auto result = learn(testing::world(small_room()), settings, [&](std::uint64_t done) {
    ++calls;
    episodes_done = done;
    return false;
  });
  ASSERT_FALSE(result.has_value());
  EXPECT_EQ(result.error().kind, ErrorKind::interrupted);
  EXPECT_EQ(calls, 1U);
  EXPECT_GT(episodes_done, 0U);
  EXPECT_LT(episodes_done, settings.episodes);
}

}  // namespace
}  // namespace coppice
