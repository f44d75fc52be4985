#include "coordinator/learning/synthetic_chain.hpp"

#include <gtest/gtest.h>

namespace coppice {
namespace {

TEST(SyntheticChain, HasTheShapeThatWasAskedFor) {
  const auto chain = synthetic_chain({.states = 5000, .actions = 4, .branching = 7, .features = 6, .seed = 3});
  ASSERT_TRUE(chain.has_value()) << chain.error().message;
  EXPECT_EQ(chain->states(), 5000U);
  EXPECT_EQ(chain->actions(), 4U);
  EXPECT_EQ(chain->transitions(), 5000U * 4 * 7);
  EXPECT_EQ(chain->vocabulary().features.size(), 6U);
  EXPECT_EQ(chain->vocabulary().features[0].values.size(), 5U);  // 4^6 < 5000 <= 5^6
  for (std::size_t row = 0; row < 5000 * 4; row += 997) {
    EXPECT_EQ(chain->successors(row).size(), 7U);
  }
}

TEST(SyntheticChain, DependsOnItsSeedAlone) {
  const SyntheticShape shape{.states = 300, .actions = 2, .branching = 3, .features = 9, .seed = 1};
  SyntheticShape other = shape;
  other.seed = 2;
  EXPECT_EQ(synthetic_chain(shape)->parts(), synthetic_chain(shape)->parts());
  EXPECT_NE(synthetic_chain(shape)->parts(), synthetic_chain(other)->parts());
}

TEST(SyntheticChain, MayBeAsSmallAsOneState) {
  EXPECT_TRUE(synthetic_chain({.states = 1, .actions = 1, .branching = 1, .features = 1, .seed = 1}).has_value());
  EXPECT_TRUE(synthetic_chain({.states = 2, .actions = 1, .branching = 2, .features = 1, .seed = 1}).has_value());
}

TEST(SyntheticChain, NamesTheFlagThatDoesNotFit) {
  const auto message = [](const SyntheticShape& shape) {
    const auto chain = synthetic_chain(shape);
    return chain ? std::string() : chain.error().message;
  };
  EXPECT_NE(message({.states = 0}).find("--states 0"), std::string::npos);
  EXPECT_NE(message({.states = 10, .branching = 11}).find("--branching 11: expected 1 to 10"), std::string::npos);
  EXPECT_NE(message({.states = 100'000, .features = 2}).find("--features 2"), std::string::npos);
  EXPECT_NE(message({.states = 200'000'000, .branching = 100, .features = 40}).find("transitions"), std::string::npos);
}

}  // namespace
}  // namespace coppice
