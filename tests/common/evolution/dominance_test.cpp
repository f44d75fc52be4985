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
  EXPECT_EQ(survivors_of({values, 2}, 2).points, (std::vector<std::size_t>{1, 4}));
  EXPECT_EQ(survivors_of({values, 2}, 3).points, (std::vector<std::size_t>{1, 3, 4}));
  EXPECT_EQ(survivors_of({values, 2}, 4).points, (std::vector<std::size_t>{1, 2, 3, 4}));
  EXPECT_EQ(survivors_of({values, 2}, 5).points, (std::vector<std::size_t>{0, 1, 2, 3, 4}));
}

std::vector<double> random_costs(Stream& stream, std::size_t points, std::size_t costs) {
  std::vector<double> values;
  for (std::size_t i = 0; i < points * costs; ++i) {
    values.push_back(static_cast<double>(stream.below(40)));
  }
  return values;
}

std::vector<double> costs_of_points(const Costs& costs, const std::vector<std::size_t>& points) {
  std::vector<double> values;
  for (const std::size_t point : points) {
    values.insert(values.end(), costs.of(point).begin(), costs.of(point).end());
  }
  return values;
}

TEST(Dominance, SurvivorsStandAmongThemselvesAsIfTheyHadAlwaysBeenAlone) {
  Stream stream(6, Purpose::simulating, 0, 0);
  for (const std::size_t costs : {1U, 2U, 3U, 5U}) {
    for (const std::size_t count : {0U, 1U, 30U, 77U, 120U}) {
      const std::vector<double> values = random_costs(stream, 120, costs);
      const Survivors survivors = survivors_of({values, costs}, count);
      ASSERT_EQ(survivors.points.size(), count);
      const std::vector<double> theirs = costs_of_points({values, costs}, survivors.points);
      const Standing alone = standing_of({theirs, costs});
      EXPECT_EQ(survivors.standing.ranks, alone.ranks) << costs << " costs, " << count << " kept";
      EXPECT_EQ(survivors.standing.crowding, alone.crowding) << costs << " costs, " << count << " kept";
    }
  }
}

TEST(Dominance, OfAFrontTheSameSurviveWithoutRanking) {
  Stream stream(7, Purpose::simulating, 0, 0);
  const std::vector<double> values = random_costs(stream, 400, 3);
  std::vector<std::size_t> front;
  const std::vector<std::uint32_t> ranks = ranks_of({values, 3});
  for (std::size_t i = 0; i < ranks.size(); ++i) {
    if (ranks[i] == 0) {
      front.push_back(i);
    }
  }
  ASSERT_GT(front.size(), 20U);
  const std::vector<double> costs = costs_of_points({values, 3}, front);
  const Survivors ranked = survivors_of({costs, 3}, 15);
  const Survivors of_front = survivors_of_front({costs, 3}, 15);
  EXPECT_EQ(of_front.points, ranked.points);
  EXPECT_EQ(of_front.standing.crowding, ranked.standing.crowding);
}

}  // namespace
}  // namespace coppice
