#include "coordinator/dispatch/cross_check.hpp"

#include <algorithm>
#include <gtest/gtest.h>

#include "tests/oracles/chains.hpp"
#include "tests/oracles/trees.hpp"

namespace coppice {
namespace {

constexpr WorkerId kWorker{7};

class CrossChecking : public ::testing::Test {
 protected:
  CrossCheck check(double share) { return {chain_, share, stop_}; }

  StopFlag stop_;
  std::shared_ptr<const Chain> chain_ = oracles::shared_random_chain({.states = 100, .seed = 9});
};

TEST_F(CrossChecking, ChecksNothingWithoutAShare) {
  CrossCheck none = check(0.0);
  EXPECT_TRUE(none.sample(kWorker, 1000).empty());
}

TEST_F(CrossChecking, ChecksEverythingWithAShareOfOne) {
  CrossCheck all = check(1.0);
  EXPECT_EQ(all.sample(kWorker, 5), (std::vector<std::uint32_t>{0, 1, 2, 3, 4}));
}

TEST_F(CrossChecking, ChecksOneOfEachOfAWorkersFirstAnswers) {
  CrossCheck few = check(1e-9);
  for (std::uint32_t i = 0; i < CrossCheck::kFirstAnswers; ++i) {
    const auto chosen = few.sample(kWorker, 10);
    ASSERT_EQ(chosen.size(), 1U) << i;
    EXPECT_LT(chosen.front(), 10U);
  }
  EXPECT_TRUE(few.sample(kWorker, 10).empty());
  EXPECT_EQ(few.sample(WorkerId{8}, 10).size(), 1U) << "another worker is new";
}

TEST_F(CrossChecking, KnowsWhatItSampledLast) {
  CrossCheck some = check(0.3);
  const auto chosen = some.sample(kWorker, 10);
  for (std::uint32_t i = 0; i < 10; ++i) {
    EXPECT_EQ(some.was_sampled(i), std::count(chosen.begin(), chosen.end(), i) == 1) << i;
  }
  EXPECT_TRUE(check(0.0).sample(kWorker, 10).empty());
  EXPECT_FALSE(check(0.0).was_sampled(0));
}

TEST_F(CrossChecking, CountsWhatNobodyCheckedUntilEverythingBeginsAgain) {
  CrossCheck some = check(0.3);
  some.took_unchecked(kWorker, 3);
  some.took_unchecked(kWorker, 4);
  EXPECT_EQ(some.unchecked(kWorker), 7U);
  EXPECT_EQ(some.unchecked(WorkerId{8}), 0U);
  some.begin_again();
  EXPECT_EQ(some.unchecked(kWorker), 0U);
}

TEST_F(CrossChecking, ChecksItsShareInTheLongRun) {
  CrossCheck tenth = check(0.1);
  std::size_t checked = 0;
  for (int i = 0; i < 1000; ++i) {
    checked += tenth.sample(kWorker, 7).size();
  }
  EXPECT_NEAR(static_cast<double>(checked), 700.0, CrossCheck::kFirstAnswers + 1.0);
}

}  // namespace
}  // namespace coppice
