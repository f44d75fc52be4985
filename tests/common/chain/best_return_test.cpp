#include "common/chain/best_return.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <vector>

#include "common/chain/exact.hpp"
#include "common/chain/random.hpp"
#include "tests/oracles/chains.hpp"

namespace coppice {
namespace {

constexpr std::uint32_t kSteps = 12;

// By the visits that another way of computing gives.
double by_visits(const Chain& chain, const std::vector<std::uint8_t>& actions, std::uint32_t steps) {
  ExactOccupancy exact(chain);
  const Occupancy& occupancy = exact.over_steps({.actions = actions, .others = {}}, steps);
  double sum = 0.0;
  for (std::size_t i = 0; i < occupancy.states.size(); ++i) {
    const std::uint32_t s = occupancy.states[i];
    if (actions[s] < chain.actions()) {
      sum += occupancy.visits[i] * chain.mean_reward(chain.row(s, ActionId{actions[s]}));
    }
  }
  return sum;
}

TEST(BestReturn, of_given_actions_is_what_their_visits_earn) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Chain chain = oracles::random_chain({.states = 80, .actions = 3, .seed = seed});
    Xoshiro256 random(seed);
    std::vector<std::uint8_t> actions;
    for (std::size_t s = 0; s < chain.states(); ++s) {
      actions.push_back(static_cast<std::uint8_t>(random.below(4)));
    }
    EXPECT_NEAR(return_of(chain, actions, kSteps), by_visits(chain, actions, kSteps), 1e-9);
  }
}

TEST(BestReturn, is_more_than_any_choice_of_actions_earns) {
  const Chain chain = oracles::random_chain({.states = 60, .actions = 3, .seed = 4});
  const double best = best_return(chain, kSteps);
  Xoshiro256 random(9);
  for (int trial = 0; trial < 300; ++trial) {
    std::vector<std::uint8_t> actions;
    for (std::size_t s = 0; s < chain.states(); ++s) {
      actions.push_back(static_cast<std::uint8_t>(random.below(4)));
    }
    EXPECT_GE(best, by_visits(chain, actions, kSteps) - 1e-9);
  }
}

TEST(BestReturn, of_one_step_is_the_best_recorded_reward_and_of_a_game_without_choice_what_it_gives) {
  const Chain chain = oracles::random_chain({.states = 60, .actions = 3, .seed = 6});
  double best = 0.0;  // doing nothing earns nothing
  for (std::size_t a = 0; a < chain.actions(); ++a) {
    best = std::max(best, chain.mean_reward(chain.row(chain.initial_state(), ActionId{static_cast<std::uint8_t>(a)})));
  }
  EXPECT_NEAR(best_return(chain, 1), best, 1e-12);
  // The gambler cannot but bet, and never gains by stopping: the reward is 1 on reaching the goal.
  const Chain ruin = oracles::gamblers_ruin({.fortune = 3, .goal = 10, .wins = 9, .losses = 10});
  const std::vector<std::uint8_t> bets(ruin.states(), 0);
  EXPECT_NEAR(best_return(ruin, 2000), return_of(ruin, bets, 2000), 1e-9);
  const double r = 10.0 / 9.0;
  EXPECT_NEAR(best_return(ruin, 5000), (1 - r * r * r) / (1 - std::pow(r, 10)), 1e-6);
}

}  // namespace
}  // namespace coppice
