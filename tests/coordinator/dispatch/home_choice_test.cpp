#include "coordinator/dispatch/home_choice.hpp"

#include <gtest/gtest.h>

namespace coppice {
namespace {

using namespace std::chrono_literals;
using Way = HomeChoice::Way;

constexpr WorkClass kWork{WorkKind::evaluate, 500};
constexpr std::uint32_t kUnits = 100;

// A run of so many requests, each of which takes so long here and there; 1 would be the better way from the start.
double cost_of_choosing(std::chrono::nanoseconds here, std::chrono::nanoseconds there, int requests) {
  HomeChoice choice(2);
  std::chrono::nanoseconds spent{0};
  for (int i = 0; i < requests; ++i) {
    Way way = choice.way(kWork, kUnits, 2);
    if (way == Way::probe) {
      const auto probe = here * HomeChoice::kProbe / kUnits;
      choice.probed(kWork, HomeChoice::kProbe, probe);
      spent += probe;
      way = choice.way(kWork, kUnits, 2);
    }
    if (way == Way::home) {
      choice.took_home(kWork, kUnits, here);
      spent += here;
    } else {
      choice.took_workers(kWork, kUnits, there);
      spent += there;
    }
  }
  return static_cast<double>(spent.count()) / static_cast<double>((std::min(here, there) * requests).count());
}

TEST(HomeChoice, CostsLittleMoreThanTheBetterWay) {
  EXPECT_LT(cost_of_choosing(70us, 400us, 1000), 1.02);
  EXPECT_LT(cost_of_choosing(140us, 350us, 1000), 1.02);
  EXPECT_LT(cost_of_choosing(6ms, 4ms, 1000), 1.02);
  EXPECT_LT(cost_of_choosing(50ms, 26ms, 200), 1.02);
  EXPECT_LT(cost_of_choosing(6ms, 30ms, 1000), 1.02) << "workers that are slower than they look";
}

TEST(HomeChoice, StaysHomeWhileNobodyIsThereUnlessItWouldTakeLong) {
  HomeChoice choice(2);
  EXPECT_EQ(choice.way(kWork, kUnits, 0), Way::probe);
  choice.probed(kWork, HomeChoice::kProbe, 8us);
  EXPECT_EQ(choice.way(kWork, kUnits, 0), Way::home);
  EXPECT_EQ(choice.way(kWork, 1'000'000, 0), Way::workers);
}

TEST(HomeChoice, ExpectsAGainOfWorkersThatAreNotThereWhereAGenerationIsLongAndTheyAreSeveral) {
  HomeChoice choice(2);
  EXPECT_FALSE(choice.would_gain(kWork, kUnits, 2)) << "nothing was measured";
  choice.probed(kWork, HomeChoice::kProbe, 8us);
  EXPECT_FALSE(choice.would_gain(kWork, kUnits, 2)) << "100 us here, and sending alone takes more";
  EXPECT_TRUE(choice.would_gain(kWork, 100 * kUnits, 2));
  EXPECT_FALSE(choice.would_gain(kWork, 100 * kUnits, 1));
}

TEST(HomeChoice, DoesNotJudgeWorkersByTheirFirstRequest) {
  HomeChoice choice(2);
  choice.probed(kWork, HomeChoice::kProbe, 8 * 500us);
  EXPECT_EQ(choice.way(kWork, kUnits, 2), Way::workers);
  choice.took_workers(kWork, kUnits, 300ms);
  EXPECT_EQ(choice.way(kWork, kUnits, 2), Way::workers);
  choice.took_workers(kWork, kUnits, 300ms);
  EXPECT_EQ(choice.way(kWork, kUnits, 2), Way::home);
}

TEST(HomeChoice, GoesToTheWorkersWhereTheyGain) {
  HomeChoice choice(2);
  choice.way(kWork, kUnits, 2);
  choice.probed(kWork, HomeChoice::kProbe, 8 * 500us);
  EXPECT_EQ(choice.way(kWork, kUnits, 2), Way::workers);
  EXPECT_EQ(choice.way(kWork, kUnits, 1), Way::home) << "one worker is no faster than the coordinator";
}

TEST(HomeChoice, FollowsWhatChanges) {
  HomeChoice choice(2);
  choice.way(kWork, kUnits, 2);
  choice.probed(kWork, HomeChoice::kProbe, 8us);
  for (int i = 0; i < 100; ++i) {
    choice.took_home(kWork, kUnits, 100us);
  }
  int sent = 0;
  for (int i = 0; i < 10'000; ++i) {  // workers are quick now
    if (choice.way(kWork, kUnits, 2) == Way::workers) {
      choice.took_workers(kWork, kUnits, 50us);
      ++sent;
    } else {
      choice.took_home(kWork, kUnits, 100us);
    }
  }
  EXPECT_GT(sent, 9'000);
}

}  // namespace
}  // namespace coppice
