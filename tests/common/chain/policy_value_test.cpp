#include "common/chain/policy_value.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <utility>
#include <vector>

#include "common/chain/exact.hpp"
#include "common/chain/random.hpp"
#include "tests/oracles/chains.hpp"

namespace coppice {
namespace {

constexpr double kGamma = 0.9;

struct Asked {
  Chain chain;
  std::vector<std::uint8_t> actions;  // no action now and then
  std::vector<std::uint8_t> others;
  std::vector<double> rewards;  // [states x (actions + 1)]
};

Asked asked(std::uint64_t seed) {
  Asked result{oracles::random_chain({.states = 60, .actions = 3, .seed = seed}), {}, {}, {}};
  Xoshiro256 random(seed + 1000);
  for (std::size_t s = 0; s < result.chain.states(); ++s) {
    result.actions.push_back(static_cast<std::uint8_t>(random.below(4)));
    result.others.push_back(static_cast<std::uint8_t>(random.below(4)));
    for (int a = 0; a < 4; ++a) {
      result.rewards.push_back(static_cast<double>(random.below(2001)) / 100.0 - 10.0);
    }
  }
  return result;
}

// By successive approximation, on whole rows: shares nothing with what is tested.
std::vector<double> iterated_values(const Asked& a) {
  const std::size_t states = a.chain.states();
  std::vector<double> values(states, 0.0);
  for (int sweep = 0; sweep < 600; ++sweep) {
    std::vector<double> next(states, 0.0);
    double mean = 0.0;
    for (const double value : values) {
      mean += value / static_cast<double>(states);
    }
    for (std::size_t s = 0; s < states; ++s) {
      double after = values[s];
      if (a.actions[s] < a.chain.actions()) {
        const std::size_t row = a.chain.row(s, ActionId{a.actions[s]});
        after = a.chain.tries(row) == 0 ? mean : 0.0;
        for (std::size_t i = 0; i < a.chain.successors(row).size(); ++i) {
          after +=
              values[a.chain.successors(row)[i]] * a.chain.counts(row)[i] / static_cast<double>(a.chain.tries(row));
        }
      }
      next[s] = a.rewards[s * 4 + a.actions[s]] + kGamma * after;
    }
    values = next;
  }
  return values;
}

double return_of(const Asked& a, std::span<const std::uint8_t> actions) {
  PolicyValue value(a.chain);
  EXPECT_TRUE(value.solve(actions, a.rewards, kGamma));
  return value.expected_return();
}

TEST(PolicyValue, solves_what_successive_approximation_converges_to) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const Asked a = asked(seed);
    PolicyValue value(a.chain);
    ASSERT_TRUE(value.solve(a.actions, a.rewards, kGamma));
    const std::vector<double> expected = iterated_values(a);
    for (std::size_t s = 0; s < expected.size(); ++s) {
      EXPECT_NEAR(value.values()[s], expected[s], 1e-9) << "state " << s << " of seed " << seed;
    }
    EXPECT_NEAR(value.expected_return(), expected[a.chain.initial_state()], 1e-9);
  }
}

TEST(PolicyValue, is_in_each_state_as_often_as_the_exact_occupancy_says) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const Asked a = asked(seed);
    PolicyValue value(a.chain);
    ASSERT_TRUE(value.solve(a.actions, a.rewards, kGamma));
    ExactOccupancy exact(a.chain);
    const Occupancy* occupancy = exact.discounted({.actions = a.actions, .others = {}}, kGamma);
    ASSERT_NE(occupancy, nullptr);
    std::vector<double> expected(a.chain.states(), 0.0);
    for (std::size_t i = 0; i < occupancy->states.size(); ++i) {
      expected[occupancy->states[i]] = occupancy->visits[i];
    }
    for (std::size_t s = 0; s < expected.size(); ++s) {
      EXPECT_NEAR(value.occupancy()[s], expected[s], 1e-12);
    }
  }
}

TEST(PolicyValue, tells_the_difference_to_any_other_policy_by_the_others_occupancy) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const Asked a = asked(seed);
    PolicyValue value(a.chain);
    PolicyValue other(a.chain);
    ASSERT_TRUE(value.solve(a.actions, a.rewards, kGamma));
    ASSERT_TRUE(other.solve(a.others, a.rewards, kGamma));
    std::vector<double> advantages;
    value.advantages(a.rewards, advantages);
    double sum = 0.0;
    for (std::size_t s = 0; s < a.chain.states(); ++s) {
      sum += other.occupancy()[s] * advantages[s * 4 + a.others[s]];
      EXPECT_NEAR(advantages[s * 4 + a.actions[s]], 0.0, 1e-9) << "what is done has no advantage";
    }
    EXPECT_NEAR(sum, (1.0 - kGamma) * (other.expected_return() - value.expected_return()), 1e-9);
  }
}

TEST(PolicyValue, tells_the_first_order_change_of_any_one_state) {
  const Asked a = asked(3);
  PolicyValue value(a.chain);
  ASSERT_TRUE(value.solve(a.actions, a.rewards, kGamma));
  std::vector<double> advantages;
  value.advantages(a.rewards, advantages);
  for (std::size_t s = 0; s < a.chain.states(); ++s) {
    std::vector<std::uint8_t> changed = a.actions;
    changed[s] = a.others[s];
    const double promised = value.occupancy()[s] * advantages[s * 4 + a.others[s]];
    const double gained = (1.0 - kGamma) * (return_of(a, changed) - value.expected_return());
    // One state changes: the sign is exact (policy improvement), the size up to how much more it is visited then.
    EXPECT_GE(promised * gained, -1e-18);
    EXPECT_LE(std::abs(gained), std::abs(promised) / (1.0 - kGamma) + 1e-9);
  }
}

TEST(PolicyValue, gives_the_return_alone_from_the_states_that_the_walk_comes_to) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    Asked a = asked(seed);
    if (seed % 2 == 0) {  // only what was tried: the walk stays among the states that it can come to
      for (std::size_t s = 0; s < a.actions.size(); ++s) {
        while (a.actions[s] < 3 && a.chain.tries(a.chain.row(s, ActionId{a.actions[s]})) == 0) {
          ++a.actions[s];
        }
      }
    }
    PolicyValue standing(a.chain);
    ASSERT_TRUE(standing.solve(a.others, a.rewards, kGamma));
    PolicyValue value(a.chain);
    for (const PolicyValue* alike : {static_cast<const PolicyValue*>(nullptr), &std::as_const(standing)}) {
      const auto alone = value.return_of(a.actions, a.rewards, kGamma, alike);
      ASSERT_TRUE(alone.has_value());
      EXPECT_NEAR(*alone, return_of(a, a.actions), 1e-9);
    }
    // Held where it starts: nothing else is walked.
    std::fill(a.actions.begin(), a.actions.end(), std::uint8_t{3});
    const auto held = value.return_of(a.actions, a.rewards, kGamma, &standing);
    ASSERT_TRUE(held.has_value());
    EXPECT_NEAR(*held, return_of(a, a.actions), 1e-9);
  }
}

}  // namespace
}  // namespace coppice
