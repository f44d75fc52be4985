#include "common/evolution/dominance.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <vector>

#include "common/chain/random.hpp"

namespace coppice {
namespace {

TEST(Dominance, NeedsNoCostLargerAndOneSmaller) {
  const auto better = [](std::vector<double> a, std::vector<double> b) { return dominates(a, b); };
  EXPECT_TRUE(better({1, 2}, {1, 3}));
  EXPECT_FALSE(better({1, 2}, {1, 2}));
  EXPECT_FALSE(better({1, 4}, {2, 3}));
}

// By the definition: a rank is what is left undominated once all lower ranks are gone.
std::vector<std::uint32_t> peeled_ranks(const Costs& costs) {
  std::vector<std::uint32_t> ranks(costs.points(), 0xFFFFFFFF);
  std::size_t left = costs.points();
  for (std::uint32_t rank = 0; left > 0; ++rank) {
    std::vector<std::size_t> peel;
    for (std::size_t i = 0; i < costs.points(); ++i) {
      bool dominated = ranks[i] != 0xFFFFFFFF;
      for (std::size_t j = 0; j < costs.points() && !dominated; ++j) {
        dominated = ranks[j] == 0xFFFFFFFF && dominates(costs.of(j), costs.of(i));
      }
      if (!dominated) {
        peel.push_back(i);
      }
    }
    for (const std::size_t i : peel) {
      ranks[i] = rank;
    }
    left -= peel.size();
  }
  return ranks;
}

TEST(Dominance, RanksAreThoseOfTheDefinition) {
  Stream stream(5, Purpose::simulating, 0, 0);
  for (const std::size_t costs : {1U, 2U, 3U, 5U}) {
    std::vector<double> values;
    for (std::size_t i = 0; i < 120 * costs; ++i) {
      values.push_back(static_cast<double>(stream.below(8)));  // few values: many ties and repeats
    }
    EXPECT_EQ(ranks_of({values, costs}), peeled_ranks({values, costs})) << costs << " costs";
  }
}

TEST(Dominance, CrowdingIsTheSumOfTheGapsByRange) {
  // One front of four points, worked by hand: gaps (3-0)/4 and (4-1)/4 for the second, (4-1)/4 and (3-0)/4 for the
  // third.
  const std::vector<double> values = {0, 4, 1, 3, 3, 1, 4, 0};
  const Costs costs{values, 2};
  const std::vector<std::uint32_t> ranks = ranks_of(costs);
  EXPECT_EQ(ranks, (std::vector<std::uint32_t>(4, 0)));
  const std::vector<double> crowding = crowding_of(costs, ranks);
  EXPECT_TRUE(std::isinf(crowding[0]) && std::isinf(crowding[3]));
  EXPECT_DOUBLE_EQ(crowding[1], 1.5);
  EXPECT_DOUBLE_EQ(crowding[2], 1.5);
}

TEST(Dominance, SurvivorsAreTheLowestRanksThenTheLeastCrowded) {
  //                                 front 0: ends, and a close pair; then one that is dominated
  const std::vector<double> values = {5, 5, 0, 4, 1.0, 2.9, 1.1, 2.8, 4, 0};
  EXPECT_EQ(survivors({values, 2}, 3), (std::vector<std::size_t>{1, 4, 3}));
  EXPECT_EQ(survivors({values, 2}, 5).back(), 0U);
}

}  // namespace
}  // namespace coppice
