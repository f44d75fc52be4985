#include "coordinator/dispatch/cross_check.hpp"

#include <gtest/gtest.h>

namespace coppice {
namespace {

constexpr WorkerId kWorker{7};

constexpr std::uint64_t kSeed = 5;

CrossCheck check(double share) { return {share, kSeed}; }

TEST(CrossChecking, ChecksNothingWithoutAShare) {
  CrossCheck none = check(0.0);
  EXPECT_TRUE(none.sample(kWorker, 1000).empty());
}

TEST(CrossChecking, ChecksEverythingWithAShareOfOne) {
  CrossCheck all = check(1.0);
  EXPECT_EQ(all.sample(kWorker, 5), (std::vector<std::uint32_t>{0, 1, 2, 3, 4}));
}

TEST(CrossChecking, ChecksOneOfEachOfAWorkersFirstAnswers) {
  CrossCheck few = check(1e-9);
  for (std::uint32_t i = 0; i < CrossCheck::kFirstAnswers; ++i) {
    const auto chosen = few.sample(kWorker, 10);
    ASSERT_EQ(chosen.size(), 1U) << i;
    EXPECT_LT(chosen.front(), 10U);
  }
  EXPECT_TRUE(few.sample(kWorker, 10).empty());
  EXPECT_EQ(few.sample(WorkerId{8}, 10).size(), 1U) << "another worker is new";
}

TEST(CrossChecking, CountsWhatNobodyCheckedUntilEverythingBeginsAgain) {
  CrossCheck some = check(0.3);
  some.took_unchecked(kWorker, 3);
  some.took_unchecked(kWorker, 4);
  EXPECT_EQ(some.unchecked(kWorker), 7U);
  EXPECT_EQ(some.unchecked(WorkerId{8}), 0U);
  some.forget_unchecked(kWorker, 5);
  EXPECT_EQ(some.unchecked(kWorker), 2U);
  some.begin_again();
  EXPECT_EQ(some.unchecked(kWorker), 0U);
}

TEST(CrossChecking, ChecksItsShareInTheLongRun) {
  CrossCheck tenth = check(0.1);
  std::size_t checked = 0;
  for (int i = 0; i < 1000; ++i) {
    checked += tenth.sample(kWorker, 7).size();
  }
  EXPECT_NEAR(static_cast<double>(checked), 700.0, CrossCheck::kFirstAnswers + 1.0);
}

}  // namespace
}  // namespace coppice
