#include "coordinator/evolution/selection.hpp"

#include <algorithm>
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
  std::vector<std::size_t> ranked(kRanks);
  for (std::size_t r = 0; r < kRanks; ++r) {
    ranked[r] = 100 + (r * 3) % kRanks;  // slots, so that a slot is not mistaken for a rank
  }
  std::vector<int> wins(kRanks, 0);
  Stream stream(1, Purpose::breeding, 1, 0);
  for (int i = 0; i < kTournaments; ++i) {
    const std::size_t slot = tournament(stream, ranked, kDraws);
    const auto rank = std::find(ranked.begin(), ranked.end(), slot) - ranked.begin();
    ++wins[static_cast<std::size_t>(rank)];
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

}  // namespace
}  // namespace coppice
