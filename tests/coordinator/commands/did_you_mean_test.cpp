#include "coordinator/commands/did_you_mean.hpp"

#include <gtest/gtest.h>

namespace coppice {
namespace {

using Words = std::vector<std::string>;

const Words kFlags = {"--workers", "--worker-program", "--wait", "--json", "--seed", "--set", "--steps"};

TEST(DidYouMean, FindsTheWordThatASlipOfTheFingerMissed) {
  EXPECT_EQ(nearest("--wokers", kFlags), Words{"--workers"}) << "a letter left out";
  EXPECT_EQ(nearest("--workerss", kFlags), Words{"--workers"}) << "one too many";
  EXPECT_EQ(nearest("--wprkers", kFlags), Words{"--workers"}) << "another one";
  EXPECT_EQ(nearest("--jsno", kFlags), Words{"--json"}) << "two swapped";
  EXPECT_EQ(nearest("evlove", {"evolve", "evaluate"}), Words{"evolve"});
}

TEST(DidYouMean, NamesAllThatAreEquallyNear) { EXPECT_EQ(nearest("--see", kFlags), (Words{"--seed", "--set"})); }

TEST(DidYouMean, CompletesABeginning) {
  EXPECT_EQ(nearest("--work", kFlags), (Words{"--workers", "--worker-program"}));
  EXPECT_EQ(nearest("eval", {"evolve", "evaluate"}), Words{"evaluate"});
}

TEST(DidYouMean, SaysNothingWhereNothingIsNear) {
  EXPECT_EQ(nearest("--colour", kFlags), Words());
  EXPECT_EQ(nearest("x", {"run", "edit"}), Words());
  EXPECT_EQ(nearest("", kFlags), Words());
  EXPECT_EQ(nearest(std::string(10'000, 'a'), kFlags), Words()) << "whatever its length";
  EXPECT_EQ(nearest("--json", {}), Words());
}

}  // namespace
}  // namespace coppice
