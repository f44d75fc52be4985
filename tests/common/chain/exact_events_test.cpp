// ExactEvents against closed forms, and against plain propagation on random chains.
#include "common/chain/exact_events.hpp"

#include <cmath>
#include <gtest/gtest.h>

#include "common/chain/exact.hpp"
#include "common/chain/random.hpp"
#include "tests/oracles/chains.hpp"

namespace coppice {
namespace {

std::vector<std::uint8_t> always(const Chain& chain, std::uint8_t action) {
  return std::vector<std::uint8_t>(chain.states(), action);
}

std::vector<double> in_state(const Chain& chain, std::initializer_list<std::size_t> states) {
  std::vector<double> chance(chain.states(), 0.0);
  for (const std::size_t state : states) {
    chance[state] = 1.0;
  }
  return chance;
}

TEST(ExactEvents, TheGamblerReachesTheGoalAsTheClosedFormSays) {
  for (const std::uint32_t fortune : {1U, 3U, 9U}) {
    const oracles::Gambler gambler{.fortune = fortune, .goal = 10, .wins = 9, .losses = 10};
    const Chain chain = oracles::gamblers_ruin(gambler);
    const auto actions = always(chain, 0);
    ExactEvents events(chain);
    events.begin({.actions = actions, .others = {}, .others_share = 0.0});
    const auto goal = events.ever(in_state(chain, {10}));
    const double r = 10.0 / 9.0;
    ASSERT_TRUE(goal);
    EXPECT_NEAR(goal->probability, (1.0 - std::pow(r, fortune)) / (1.0 - std::pow(r, 10)), 1e-12);
    // Either end: certain, and the duration of play (Feller, volume 1, XIV.3), with the act in the end state itself.
    const auto end = events.ever(in_state(chain, {0, 10}));
    const double p = 9.0 / 19.0;
    const double q = 10.0 / 19.0;
    const double duration = fortune / (q - p) - 10.0 / (q - p) * (1.0 - std::pow(r, fortune)) / (1.0 - std::pow(r, 10));
    ASSERT_TRUE(end);
    EXPECT_EQ(end->probability, 1.0);
    EXPECT_NEAR(end->steps, duration + 1.0, 1e-9);
    EXPECT_NEAR(events.within(in_state(chain, {10}), 100'000), goal->probability, 1e-12);
  }
}

TEST(ExactEvents, KnuthsDieShowsEveryFaceAlikeAfterElevenThirdsFlips) {
  const Chain chain = oracles::knuth_die();
  const auto actions = always(chain, 0);
  ExactEvents events(chain);
  events.begin({.actions = actions, .others = {}, .others_share = 0.0});
  for (std::size_t face = 7; face <= 12; ++face) {
    EXPECT_NEAR(events.ever(in_state(chain, {face}))->probability, 1.0 / 6.0, 1e-14);
  }
  const auto any = events.ever(in_state(chain, {7, 8, 9, 10, 11, 12}));
  EXPECT_EQ(any->probability, 1.0);
  EXPECT_NEAR(any->steps, 11.0 / 3.0 + 1.0, 1e-12);  // the flips, and the act in the face
}

TEST(ExactEvents, WhatCannotHappenNeverDoes) {
  const Chain chain = oracles::gamblers_ruin({});
  const auto actions = always(chain, 1);  // the number of actions: none, so it holds its state
  ExactEvents events(chain);
  events.begin({.actions = actions, .others = {}, .others_share = 0.0});
  EXPECT_EQ(events.within(in_state(chain, {0}), 1000), 0.0);
  const auto ruin = events.ever(in_state(chain, {0}));
  ASSERT_TRUE(ruin);
  EXPECT_EQ(ruin->probability, 0.0);
  EXPECT_EQ(ruin->steps, 0.0);
}

// P(event at step i), i < steps, by plain propagation; a pair that was never tried ends the walk.
std::vector<double> propagated(const Chain& chain, const std::vector<std::uint8_t>& actions,
                               const std::vector<double>& chance, std::size_t steps) {
  std::vector<double> met;
  std::vector<double> now(chain.states(), 0.0);
  now[chain.initial_state()] = 1.0;
  for (std::size_t step = 0; step < steps; ++step) {
    std::vector<double> next(chain.states(), 0.0);
    met.push_back(0.0);
    for (std::size_t s = 0; s < chain.states(); ++s) {
      met.back() += now[s] * chance[s];
      const double on = now[s] * (1.0 - chance[s]);
      const std::size_t row = s * chain.actions() + actions[s];
      for (std::size_t i = 0; i < chain.successors(row).size(); ++i) {
        next[chain.successors(row)[i]] +=
            on * static_cast<double>(chain.counts(row)[i]) / static_cast<double>(chain.tries(row));
      }
    }
    now = next;
  }
  return met;
}

TEST(ExactEvents, OnRandomChainsTheyAreThoseOfPropagation) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Chain chain = oracles::random_chain({.states = 60, .actions = 3, .seed = seed});
    Xoshiro256 random(seed);
    std::vector<std::uint8_t> actions;
    std::vector<double> chance;
    for (std::size_t s = 0; s < chain.states(); ++s) {
      actions.push_back(static_cast<std::uint8_t>(random.below(3)));
      // Certain, possible or impossible.
      chance.push_back(random.below(10) == 0 ? (random.below(2) == 0 ? 1.0 : 0.25) : 0.0);
    }
    ExactEvents events(chain);
    events.begin({.actions = actions, .others = {}, .others_share = 0.0});
    const std::vector<double> met = propagated(chain, actions, chance, 5000);
    double sum = 0.0;
    double weighted = 0.0;
    for (std::size_t i = 0; i < met.size(); ++i) {
      if (i == 50) {
        EXPECT_NEAR(events.within(chance, 50), sum, 1e-12);
      }
      sum += met[i];
      weighted += met[i] * static_cast<double>(i + 1);
    }
    const auto first = events.ever(chance);
    ASSERT_TRUE(first);
    EXPECT_NEAR(first->probability, sum, 1e-9) << "seed " << seed;
    EXPECT_NEAR(first->steps * sum, weighted, 1e-6) << "seed " << seed;
  }
}

TEST(ExactEvents, ProbabilitiesReplaceTheCounts) {
  const Chain chain = oracles::gamblers_ruin({.fortune = 3, .goal = 10, .wins = 9, .losses = 10});
  const Chain fair = oracles::gamblers_ruin({.fortune = 3, .goal = 10, .wins = 1, .losses = 1});
  const auto actions = always(chain, 0);
  std::vector<double> probabilities;
  for (std::size_t row = 0; row < fair.states(); ++row) {
    for (const std::uint32_t count : fair.counts(row)) {
      probabilities.push_back(static_cast<double>(count) / static_cast<double>(fair.tries(row)));
    }
  }
  ExactEvents events(chain);
  events.begin({.actions = actions, .others = {}, .others_share = 0.0}, probabilities);
  EXPECT_NEAR(events.ever(in_state(chain, {10}))->probability, 0.3, 1e-12);
  events.begin({.actions = actions, .others = {}, .others_share = 0.0});
  EXPECT_LT(events.ever(in_state(chain, {10}))->probability, 0.25);
  ExactOccupancy occupancy(chain);
  occupancy.set_probabilities(probabilities);
  ExactOccupancy of_fair(fair);
  const ActingTables acting{.actions = actions, .others = {}, .others_share = 0.0};
  EXPECT_EQ(occupancy.over_steps(acting, 20).visits, of_fair.over_steps(acting, 20).visits);
}

}  // namespace
}  // namespace coppice
