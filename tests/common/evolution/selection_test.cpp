#include "common/evolution/selection.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <vector>

#include "tests/coordinator/evolution/small_world.hpp"

namespace coppice {
namespace {

using testing::tree_of;

TEST(Ranking, PutsFitnessBeforeSizeBeforeSlot) {
  const std::vector<Tree> population = {tree_of("(sequence a=0 left)"), tree_of("move"), tree_of("left"),
                                        tree_of("(sequence a=0 b=0 left)"), tree_of("right")};
  const std::vector<double> fitness = {0.5, 0.5, 0.5, 0.9, -1.0};
  EXPECT_EQ(ranking(population, fitness), (std::vector<std::size_t>{3, 1, 2, 0, 4}));
}

TEST(Tournament, HasItsShareOfThePopulationAndAtLeastOne) {
  EXPECT_EQ(tournament_size(0.08, 100), 8U);
  EXPECT_EQ(tournament_size(0.08, 10), 1U);
  EXPECT_EQ(tournament_size(0.0, 50), 1U);
  EXPECT_EQ(tournament_size(1.0, 50), 50U);
}

TEST(Tournament, IsWonByARankAsOftenAsTheoryHasIt) {
  // Of k draws from n ranks the best is r or worse with probability ((n - r) / n)^k.
  constexpr std::size_t kRanks = 10;
  constexpr std::size_t kDraws = 3;
  constexpr int kTournaments = 200'000;
  std::vector<double> fitness(kRanks);
  for (std::size_t slot = 0; slot < kRanks; ++slot) {
    fitness[slot] = -static_cast<double>(slot * 3 % kRanks);  // rank slot * 3 % 10
  }
  std::vector<int> wins(kRanks, 0);
  Stream stream(1, Purpose::breeding, 1, 0);
  for (int i = 0; i < kTournaments; ++i) {
    ++wins[tournament(stream, fitness, kDraws) * 3 % kRanks];
  }
  for (std::size_t r = 0; r < kRanks; ++r) {
    const auto at_least = [&](std::size_t from) {
      return std::pow(static_cast<double>(kRanks - from) / static_cast<double>(kRanks), static_cast<double>(kDraws));
    };
    const double p = at_least(r) - at_least(r + 1);
    const double sigma = std::sqrt(p * (1.0 - p) * kTournaments);
    EXPECT_NEAR(wins[r], p * kTournaments, 5.0 * sigma) << "rank " << r;
  }
}

TEST(Tournament, HasNoFavouriteAmongEquals) {
  const std::vector<double> fitness(10, 0.5);
  constexpr int kTournaments = 100'000;
  std::vector<int> wins(fitness.size(), 0);
  Stream stream(2, Purpose::breeding, 1, 0);
  for (int i = 0; i < kTournaments; ++i) {
    ++wins[tournament(stream, fitness, 4)];
  }
  for (const int won : wins) {
    EXPECT_NEAR(won, kTournaments / 10.0, 5.0 * std::sqrt(kTournaments * 0.1 * 0.9));
  }
}

}  // namespace
}  // namespace coppice
