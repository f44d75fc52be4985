#include "coordinator/learning/windy_grid.hpp"

#include <gtest/gtest.h>

#include "common/chain/random.hpp"

namespace coppice {
namespace {

constexpr std::uint32_t kUp = 0;
constexpr std::uint32_t kDown = 1;
constexpr std::uint32_t kGridLeft = 2;
constexpr std::uint32_t kGridRight = 3;

class WindyGridTest : public ::testing::Test {
 protected:
  Outcome go(std::uint32_t action, int times = 1) {
    Outcome outcome;
    for (int i = 0; i < times; ++i) {
      outcome = grid_.step(action, random_);
    }
    return outcome;
  }
  WindyGrid grid_;
  Xoshiro256 random_{1};
};

TEST_F(WindyGridTest, MovesPlainlyWithoutWind) {
  go(kUp);
  EXPECT_EQ(grid_.place(), (WindyGrid::Place{0, 2}));
  go(kGridRight);
  EXPECT_EQ(grid_.place(), (WindyGrid::Place{1, 2}));
  go(kDown, 2);
  EXPECT_EQ(grid_.place(), (WindyGrid::Place{1, 4}));
  go(kGridLeft);
  EXPECT_EQ(grid_.place(), (WindyGrid::Place{0, 4}));
}

TEST_F(WindyGridTest, IsBlownUpByTheWindOfTheColumnThatItLeaves) {
  go(kGridRight, 3);
  EXPECT_EQ(grid_.place(), (WindyGrid::Place{3, 3}));
  go(kGridRight);
  EXPECT_EQ(grid_.place(), (WindyGrid::Place{4, 2}));
  go(kDown);
  EXPECT_EQ(grid_.place(), (WindyGrid::Place{4, 2}));
  go(kUp);
  EXPECT_EQ(grid_.place(), (WindyGrid::Place{4, 0}));
}

TEST_F(WindyGridTest, StaysInTheGridAtTheUsualCost) {
  EXPECT_EQ(go(kGridLeft).reward, -1.0);
  EXPECT_EQ(grid_.place(), WindyGrid::kStart);
  EXPECT_FALSE(go(kDown, 10).collided);
  EXPECT_EQ(grid_.place(), (WindyGrid::Place{0, 7}));
  EXPECT_EQ(go(kUp, 10).reward, -1.0);
  EXPECT_EQ(grid_.place(), (WindyGrid::Place{0, 0}));
  go(kGridRight, 12);
  EXPECT_EQ(grid_.place(), (WindyGrid::Place{9, 0}));
}

TEST_F(WindyGridTest, EndsAtTheGoalWithTheGoalsReward) {
  go(kGridRight, 9);
  go(kDown, 4);
  go(kGridLeft);
  EXPECT_EQ(grid_.place(), (WindyGrid::Place{8, 4}));
  const Outcome outcome = go(kGridLeft);
  EXPECT_EQ(grid_.place(), WindyGrid::kGoal);
  EXPECT_TRUE(outcome.ended);
  EXPECT_EQ(outcome.reward, 9.0);
  grid_.reset(0);
  EXPECT_EQ(grid_.place(), WindyGrid::kStart);
}

TEST(WindyGrid, CodesAndFeaturesAreInverse) {
  for (std::uint32_t code = 0; code < WindyGrid::kCodes; ++code) {
    std::array<std::uint8_t, 2> features{};
    WindyGrid::features_of(code, features);
    EXPECT_EQ(WindyGrid::code_of(features), code);
  }
}

TEST(WindyGrid, HasAVocabularyThatHolds) {
  const Vocabulary vocabulary = WindyGrid::vocabulary();
  EXPECT_TRUE(check_vocabulary(vocabulary).has_value());
  EXPECT_EQ(vocabulary.actions, (std::vector<std::string>{"up", "down", "left", "right"}));
  ASSERT_EQ(vocabulary.features.size(), 2U);
  EXPECT_EQ(vocabulary.features[0].values.size(), 10U);
  EXPECT_EQ(vocabulary.features[1].values.size(), 8U);
  for (const Feature& feature : vocabulary.features) {
    EXPECT_TRUE(feature.admits(Op::equal) && feature.admits(Op::less_equal));
  }
}

}  // namespace
}  // namespace coppice
