// Every figure here is worked out by hand from the rules in battery_room.hpp.
#include "coordinator/learning/battery_room.hpp"

#include <array>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "common/chain/random.hpp"
#include "tests/coordinator/learning/rooms.hpp"

namespace coppice {
namespace {

constexpr std::uint32_t kForward = 0;
constexpr std::uint32_t kTurnRight = 2;
constexpr std::uint32_t kCharge = BatteryRoom::kCharge;

struct Reading {
  std::uint32_t charge;
  std::uint32_t charger;
  bool operator==(const Reading&) const = default;
};

Reading reading(const BatteryRoom& battery_room) {
  std::array<std::uint8_t, BatteryRoom::kFeatures> features{};
  BatteryRoom::features_of(battery_room.code(), features);
  return {features[8], features[9]};
}

class BatteryRoomTest : public ::testing::Test {
 protected:
  Outcome go(std::uint32_t action, int times = 1) {
    Outcome outcome;
    for (int i = 0; i < times; ++i) {
      outcome = room_.step(action, random_);
    }
    return outcome;
  }
  BatteryRoom room_{testing::room({"#####", "#^.*#", "#..C#", "#>..#", "#####"})};
  Xoshiro256 random_{1};
};

TEST_F(BatteryRoomTest, EveryStepTakesOneAndTheChargeIsReadInFifths) {
  EXPECT_EQ(room_.battery(), 100U);
  for (std::uint32_t left = 100; left > 1; --left) {
    EXPECT_EQ(room_.battery(), left);
    EXPECT_EQ(reading(room_).charge, left > 80 ? 4U : left > 60 ? 3U : left > 40 ? 2U : left > 20 ? 1U : 0U) << left;
    EXPECT_EQ(go(kTurnRight).reward, -1.0);
  }
}

TEST_F(BatteryRoomTest, WithTheLastStepItFalls) {
  go(kTurnRight, 99);
  EXPECT_EQ(room_.battery(), 1U);
  const Outcome fall = go(kTurnRight);
  EXPECT_EQ(fall.reward, -100.0);
  EXPECT_TRUE(fall.collided);
  EXPECT_TRUE(fall.ended);
  EXPECT_EQ(reading(room_).charge, 0U);
  room_.reset(1);
  EXPECT_EQ(room_.battery(), 100U);
  EXPECT_EQ(room_.map().starts, (std::vector<RoomStart>{{16, Heading::right}}));
}

TEST_F(BatteryRoomTest, ChargesOnTheChargerOnlyAndUpToFull) {
  EXPECT_EQ(go(kCharge).reward, -1.0);
  EXPECT_EQ(room_.battery(), 99U);
  // From (1,1) up to (3,2): right, two on, right, one down.
  go(kTurnRight);
  go(kForward, 2);
  go(kTurnRight);
  go(kForward);
  EXPECT_EQ(reading(room_).charger, 0U);
  EXPECT_EQ(room_.battery(), 94U);
  EXPECT_EQ(go(kCharge).reward, 0.0);
  EXPECT_EQ(room_.battery(), 100U);
  go(kTurnRight, 60);
  EXPECT_EQ(room_.battery(), 40U);
  go(kCharge);
  EXPECT_EQ(room_.battery(), 64U);
}

TEST_F(BatteryRoomTest, ItCanBeSavedWithTheLastStep) {
  go(kTurnRight);
  go(kForward, 2);
  go(kTurnRight);
  go(kForward);
  go(kTurnRight, 94);
  EXPECT_EQ(room_.battery(), 1U);
  EXPECT_FALSE(go(kCharge).ended);
  EXPECT_EQ(room_.battery(), 25U);
}

TEST_F(BatteryRoomTest, AWallIsACollisionThatEndsNothing) {
  const Outcome outcome = go(kForward);
  EXPECT_EQ(outcome.reward, -10.0);
  EXPECT_TRUE(outcome.collided);
  EXPECT_FALSE(outcome.ended);
  EXPECT_EQ(room_.battery(), 99U);
}

TEST(BatteryRoom, TheBearingIsThatOfTheLongerWay) {
  // The charger is in the middle of 5 x 5 cells, at (3, 3).
  struct Place {
    int x;
    int y;
    std::array<std::uint32_t, 4> by_heading;  // ^ > v <
  };
  const std::vector<Place> places{
      {3, 1, {3, 2, 1, 4}},                        // above it
      {5, 3, {4, 3, 2, 1}},                        // to the right of it
      {3, 5, {1, 4, 3, 2}},                        // below it
      {1, 3, {2, 1, 4, 3}},                        // to the left of it
      {1, 1, {3, 1, 1, 3}},                        // a corner: equal ways count as ahead or behind
      {5, 5, {1, 3, 3, 1}}, {1, 2, {2, 1, 4, 3}},  // two to the right, one down
      {4, 5, {1, 4, 3, 2}},                        // one to the left, two up
  };
  for (const Place& place : places) {
    for (std::size_t heading = 0; heading < 4; ++heading) {
      std::vector<std::string> lines{"#######", "#.....#", "#.....#", "#..C..#", "#.....#", "#.....#", "#######"};
      lines[static_cast<std::size_t>(place.y)][static_cast<std::size_t>(place.x)] = "^>v<"[heading];
      EXPECT_EQ(reading(BatteryRoom(testing::room(lines))).charger, place.by_heading[heading])
          << "(" << place.x << ", " << place.y << ") heading " << heading;
    }
  }
}

TEST(BatteryRoom, CodesAndFeaturesAreInverse) {
  for (std::uint32_t code = 0; code < BatteryRoom::kCodes; ++code) {
    std::array<std::uint8_t, BatteryRoom::kFeatures> features{};
    BatteryRoom::features_of(code, features);
    ASSERT_EQ(BatteryRoom::code_of(features), code);
  }
}

TEST(BatteryRoom, HasAVocabularyThatHolds) {
  const Vocabulary vocabulary = BatteryRoom::vocabulary();
  EXPECT_TRUE(check_vocabulary(vocabulary).has_value());
  EXPECT_EQ(vocabulary.actions, (std::vector<std::string>{"move", "turn_left", "turn_right", "charge"}));
  ASSERT_EQ(vocabulary.features.size(), 10U);
  EXPECT_TRUE(vocabulary.features[8].admits(Op::less_equal));
  EXPECT_FALSE(vocabulary.features[9].admits(Op::less_equal));
}

}  // namespace
}  // namespace coppice
