#include "coordinator/exchange/counting.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numeric>

#include "common/chain/random.hpp"

namespace coppice {
namespace {

std::uint64_t sum_of(const std::vector<std::uint32_t>& counts) {
  return std::accumulate(counts.begin(), counts.end(), std::uint64_t{0});
}

TEST(Counting, FractionsAsToolsPrintThemBecomeExact) {
  const std::vector<std::uint32_t> thirds = counts_of(std::vector<double>{0.3333333333, 0.6666666667});
  EXPECT_EQ(2 * std::uint64_t{thirds[0]}, thirds[1]);
  const std::vector<std::uint32_t> tenths = counts_of(std::vector<double>{0.1, 0.2, 0.7});
  EXPECT_EQ(tenths[1], 2 * tenths[0]);
  EXPECT_EQ(tenths[2], 7 * tenths[0]);
  const std::vector<std::uint32_t> odd = counts_of(std::vector<double>{1.0 / 2197.0, 2196.0 / 2197.0});
  EXPECT_EQ(std::uint64_t{2196} * odd[0], odd[1]);
  EXPECT_EQ(counts_of(std::vector<double>{1.0}), std::vector<std::uint32_t>{kMostCounts});
  for (const auto& counts : {thirds, tenths, odd}) {
    EXPECT_GT(sum_of(counts), kMostCounts - 10'000U);
    EXPECT_LE(sum_of(counts), kMostCounts);
  }
}

TEST(Counting, EveryCountIsWithinOneOfItsShareAndNoneIsLost) {
  Xoshiro256 random(7);
  for (int trial = 0; trial < 300; ++trial) {
    std::vector<double> probabilities(1 + random.below(40));
    double sum = 0.0;
    for (double& p : probabilities) {
      p = std::pow(static_cast<double>(random.below(1U << 20U) + 1) / 1048576.0, 4.0);
      sum += p;
    }
    for (double& p : probabilities) {
      p /= sum;
    }
    const std::vector<std::uint32_t> counts = counts_of(probabilities);
    const auto all = static_cast<double>(sum_of(counts));
    for (std::size_t i = 0; i < counts.size(); ++i) {
      EXPECT_LE(std::abs(counts[i] - probabilities[i] * all), 1.0 + 1e-6) << trial;
    }
    EXPECT_LE(sum_of(counts), kMostCounts);
  }
}

TEST(Counting, WhatIsTooImprobableForACountGetsNone) {
  const std::vector<std::uint32_t> counts = counts_of(std::vector<double>{1e-12, 1.0 - 1e-12});
  EXPECT_EQ(counts[0], 0U);
  EXPECT_EQ(counts[1], kMostCounts);
}

}  // namespace
}  // namespace coppice
