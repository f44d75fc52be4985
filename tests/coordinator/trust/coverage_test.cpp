// How often an interval of verify() holds the truth: chains whose probabilities are known are counted anew, again and
// again, with as many tries a pair as learning might have had.
#include <algorithm>
#include <gtest/gtest.h>
#include <utility>
#include <vector>

#include "common/chain/random.hpp"
#include "common/tree/text.hpp"
#include "coordinator/trust/verification.hpp"
#include "tests/oracles/chains.hpp"

namespace coppice {
namespace {

// Every tried pair of `truth` with that many tries, their successors drawn from its probabilities. Rewards are known
// exactly, as verify() takes them to be.
Chain counted_again(const Chain& truth, std::uint32_t tries, Xoshiro256& random) {
  ChainParts parts = truth.parts();
  parts.successor.clear();
  parts.count.clear();
  parts.row_begin = {0};
  for (std::size_t row = 0; row < truth.states() * truth.actions(); ++row) {
    const auto successors = truth.successors(row);
    const auto counts = truth.counts(row);
    std::vector<std::uint32_t> drawn(successors.size(), 0);
    for (std::uint32_t i = 0; i < tries && !successors.empty(); ++i) {
      std::uint64_t place = random.below(truth.tries(row));
      std::size_t which = 0;
      for (; place >= counts[which]; ++which) {
        place -= counts[which];
      }
      ++drawn[which];
    }
    for (std::size_t i = 0; i < drawn.size(); ++i) {
      if (drawn[i] > 0) {
        parts.successor.push_back(successors[i]);
        parts.count.push_back(drawn[i]);
      }
    }
    parts.row_begin.push_back(parts.successor.size());
    parts.reward_sum[row] = truth.mean_reward(row) * tries;
  }
  return *Chain::make(std::move(parts));
}

struct Coverage {
  int asked = 0;   // intervals that were not called too narrow
  int held = 0;    // of these: with the truth inside
  int narrow = 0;  // called too narrow
  int narrow_held = 0;
};

Coverage coverage(const Chain& truth, const Tree& tree, std::uint32_t tries, int repetitions) {
  VerifySettings settings;
  settings.steps = 20;
  settings.resamples = 100;
  const double reward = verify(truth, tree, {}, {}, settings, {})->reward.value;
  Xoshiro256 random(tries);
  Coverage result;
  for (int i = 0; i < repetitions; ++i) {
    settings.seed = static_cast<std::uint64_t>(i);
    const auto found = verify(counted_again(truth, tries, random), tree, {}, {}, settings, {});
    const bool holds = found->reward.low <= reward && reward <= found->reward.high;
    (found->intervals_too_narrow() ? result.narrow : result.asked) += 1;
    (found->intervals_too_narrow() ? result.narrow_held : result.held) += holds ? 1 : 0;
  }
  return result;
}

// 95 % less five standard deviations of the share of 300.
constexpr double kAtLeast = 0.95 - 5.0 * 0.0126;

TEST(Coverage, WhereAllSuccessorsAreMetTheIntervalsHoldTheTruthAsOftenAsTheySay) {
  const Chain truth = oracles::gamblers_ruin({});
  for (const std::uint32_t tries : {30U, 300U, 3000U}) {
    const Coverage found = coverage(truth, *parse_tree("bet", truth.vocabulary()), tries, 300);
    EXPECT_EQ(found.narrow, 0) << tries;
    EXPECT_GE(found.held, kAtLeast * found.asked) << tries;
  }
}

// Thirty states in a ring, each with a reward of its own; `go` leads to one of the next twelve, each as likely.
Chain ring() {
  constexpr std::uint32_t kStates = 30;
  constexpr std::uint32_t kNext = 12;
  ChainParts parts;
  parts.vocabulary.features = {{"at", {}}};
  parts.vocabulary.actions = {"go"};
  parts.row_begin = {0};
  for (std::uint32_t state = 0; state < kStates; ++state) {
    parts.vocabulary.features[0].values.push_back(static_cast<std::uint8_t>(state));
    parts.features.push_back(static_cast<std::uint8_t>(state));
    std::vector<std::uint32_t> next;
    for (std::uint32_t i = 1; i <= kNext; ++i) {
      next.push_back((state + i) % kStates);
    }
    std::sort(next.begin(), next.end());
    parts.successor.insert(parts.successor.end(), next.begin(), next.end());
    parts.count.insert(parts.count.end(), kNext, 1);
    parts.row_begin.push_back(parts.successor.size());
    parts.reward_sum.push_back(kNext * static_cast<double>(state * state % 17));
    parts.q.push_back(0.0);
    parts.policy.push_back(ActionId{0});
    parts.visits.push_back(kNext);
  }
  return *Chain::make(std::move(parts));
}

TEST(Coverage, WhereManySuccessorsAreMissedTheIntervalsSayThatTheyAreTooNarrow) {
  const Chain truth = ring();
  const Tree tree = *parse_tree("go", truth.vocabulary());
  const Coverage few = coverage(truth, tree, 6, 100);
  EXPECT_EQ(few.asked, 0);
  const Coverage many = coverage(truth, tree, 3000, 100);
  EXPECT_EQ(many.narrow, 0);
  EXPECT_GE(many.held, (0.95 - 5.0 * 0.0218) * many.asked);
}

}  // namespace
}  // namespace coppice
