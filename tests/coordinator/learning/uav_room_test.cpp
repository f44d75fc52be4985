#include "coordinator/learning/uav_room.hpp"

#include <algorithm>
#include <array>
#include <gtest/gtest.h>
#include <set>

#include "common/chain/random.hpp"
#include "coordinator/learning/rooms.hpp"
#include "tests/coordinator/learning/rooms.hpp"

namespace coppice {
namespace {

using testing::room;
using testing::small_room;

using Readings = std::array<std::uint8_t, UavRoom::kSensors>;
constexpr std::uint32_t kMove = 0;
constexpr std::uint32_t kLeft = 1;
constexpr std::uint32_t kRight = 2;
constexpr char kHeadingMarks[] = "^>v<";

Readings readings(const UavRoom& uav_room) {
  Readings result{};
  UavRoom::features_of(uav_room.code(), result);
  return result;
}

// Answers every draw with the same number, and remembers what was asked.
struct Scripted {
  std::uint64_t answer = 0;
  std::uint64_t asked_below = 0;
  std::uint64_t below(std::uint64_t n) {
    asked_below = n;
    return answer;
  }
};

std::size_t pieces(const RoomMap& map) {
  return static_cast<std::size_t>(std::count(map.cells.begin(), map.cells.end(), Cell::trash));
}

// An open room of 7 x 7 floor cells with the UAV in the middle, and one other mark at (dx, dy) from it.
RoomMap open_room(char uav, int dx, int dy, char mark) {
  std::vector<std::string> lines(9, "#.......#");
  lines.front() = lines.back() = "#########";
  lines[static_cast<std::size_t>(4 + dy)][static_cast<std::size_t>(4 + dx)] = mark;
  lines[4][4] = uav;
  return room(lines);
}

struct Offset {
  int dx;
  int dy;
};
// Where s0 to s7 look when the UAV faces up the page; dy grows downwards.
constexpr std::array<Offset, 8> kFacingUp{{{-2, 0}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}, {1, 0}, {2, 0}, {0, -2}}};
constexpr std::array<int, 8> kHides{-1, 0, -1, 7, -1, 6, -1, -1};

Offset turned(Offset offset, std::size_t quarter_turns_right) {
  for (std::size_t i = 0; i < quarter_turns_right; ++i) {
    offset = {-offset.dy, offset.dx};
  }
  return offset;
}

TEST(UavRoom, EachSensorSeesTrashInItsOwnCellInEveryHeading) {
  for (std::size_t heading = 0; heading < kHeadings; ++heading) {
    for (std::size_t sensor = 0; sensor < 8; ++sensor) {
      const Offset at = turned(kFacingUp[sensor], heading);
      Readings expected{1, 1, 1, 1, 1, 1, 1, 1};
      expected[sensor] = 3;
      EXPECT_EQ(readings(UavRoom(open_room(kHeadingMarks[heading], at.dx, at.dy, '*'))), expected)
          << "heading " << heading << " sensor " << sensor;
    }
  }
}

TEST(UavRoom, AWallIsSeenAndHidesTheCellBehindIt) {
  for (std::size_t heading = 0; heading < kHeadings; ++heading) {
    for (std::size_t sensor = 0; sensor < 8; ++sensor) {
      const Offset at = turned(kFacingUp[sensor], heading);
      Readings expected{1, 1, 1, 1, 1, 1, 1, 1};
      expected[sensor] = 0;
      if (kHides[sensor] >= 0) {
        expected[static_cast<std::size_t>(kHides[sensor])] = 0;
      }
      EXPECT_EQ(readings(UavRoom(open_room(kHeadingMarks[heading], at.dx, at.dy, '#'))), expected)
          << "heading " << heading << " sensor " << sensor;
    }
  }
}

TEST(UavRoom, TrashBehindAWallReadsWallAndTrashHidesNothing) {
  EXPECT_EQ(readings(UavRoom(room({"######", "#.*..#", "#.##.#", "#.^..#", "######"}))),
            (Readings{0, 1, 1, 0, 0, 1, 1, 0}));
  EXPECT_EQ(readings(UavRoom(room({"#######", "#..*..#", "#..*..#", "#**^**#", "#######"}))),
            (Readings{3, 3, 1, 3, 1, 3, 3, 3}));
}

TEST(UavRoom, InACellOfItsOwnSeesOnlyWalls) {
  UavRoom uav_room(room({"###", "#<#", "###"}));
  EXPECT_EQ(readings(uav_room), (Readings{0, 0, 0, 0, 0, 0, 0, 0}));
}

TEST(UavRoom, CodesAndFeaturesAreInverse) {
  for (std::uint32_t code = 0; code < UavRoom::kCodes; ++code) {
    Readings features{};
    UavRoom::features_of(code, features);
    ASSERT_EQ(UavRoom::code_of(features), code);
  }
}

TEST(UavRoom, MovesAndTurnsWithTheRewardsOfTheThesis) {
  UavRoom uav_room(room({"#####", "#...#", "#...#", "#.^.#", "#####"}));
  Scripted random;
  const auto expect = [&](std::uint32_t action, double reward, std::size_t cell, Heading heading) {
    const Outcome outcome = uav_room.step(action, random);
    EXPECT_EQ(outcome.reward, reward);
    EXPECT_FALSE(outcome.collided);
    EXPECT_FALSE(outcome.ended);
    EXPECT_EQ(uav_room.cell(), cell);
    EXPECT_EQ(uav_room.heading(), heading);
  };
  expect(kMove, 0.0, 12, Heading::up);
  expect(kRight, -1.0, 12, Heading::right);
  expect(kMove, 0.0, 13, Heading::right);
  expect(kRight, -1.0, 13, Heading::down);
  expect(kMove, 0.0, 18, Heading::down);
  expect(kRight, -1.0, 18, Heading::left);
  expect(kMove, 0.0, 17, Heading::left);
  expect(kRight, -1.0, 17, Heading::up);
  expect(kLeft, -1.0, 17, Heading::left);
  expect(kLeft, -1.0, 17, Heading::down);
  expect(kLeft, -1.0, 17, Heading::right);
  expect(kLeft, -1.0, 17, Heading::up);
}

TEST(UavRoom, ACollisionCostsTenAndTheUavStays) {
  UavRoom uav_room(room({"####", "#>*#", "#..#", "####"}));
  Scripted random;
  EXPECT_EQ(uav_room.step(kLeft, random).reward, -1.0);
  for (int i = 0; i < 3; ++i) {
    const Outcome outcome = uav_room.step(kMove, random);
    EXPECT_EQ(outcome.reward, -10.0);
    EXPECT_TRUE(outcome.collided);
    EXPECT_EQ(uav_room.cell(), 5U);
    EXPECT_EQ(uav_room.heading(), Heading::up);
  }
  EXPECT_EQ(random.asked_below, 0U);
}

TEST(UavRoom, CollectedTrashComesBackOnEveryFreeCellAlike) {
  const std::vector<std::string> lines{"######", "#*..*#", "#>*.##", "######"};
  std::set<std::size_t> places;
  // 7 floor cells, 2 other pieces of trash, and the UAV's own: 4 are free, each drawn by one number.
  constexpr std::uint64_t kFree = 4;
  for (std::uint64_t drawn = 0; drawn < kFree; ++drawn) {
    UavRoom uav_room(room(lines));
    Scripted random{drawn, 0};
    const Outcome outcome = uav_room.step(kMove, random);
    EXPECT_EQ(outcome.reward, 20.0);
    EXPECT_FALSE(outcome.collided);
    EXPECT_EQ(random.asked_below, kFree);
    const RoomMap map = uav_room.map();
    EXPECT_EQ(pieces(map), 3U);
    EXPECT_EQ(map.cells[map.starts.front().cell], Cell::free);
    for (const std::size_t cell : {std::size_t{8}, std::size_t{9}, std::size_t{13}, std::size_t{15}}) {
      if (map.cells[cell] == Cell::trash) {
        places.insert(cell);
      }
    }
  }
  EXPECT_EQ(places.size(), kFree);
}

TEST(UavRoom, TheCellThatTheUavLeftIsEnoughForANewPiece) {
  UavRoom uav_room(room({"####", "#>*#", "####"}));
  Scripted random;
  EXPECT_EQ(uav_room.step(kMove, random).reward, 20.0);
  EXPECT_EQ(random.asked_below, 1U);
  EXPECT_EQ(uav_room.map().cells[5], Cell::trash);
  EXPECT_EQ(uav_room.step(kMove, random).reward, -10.0);
}

// However it came about, what the UAV sees is what a fresh look at the same map shows, and the pieces are as many.
TEST(UavRoom, KeepsItsCodesAndTrashThroughALongWalk) {
  for (const RoomMap& start : {room(small_room()), parse_room(default_room()).value()}) {
    UavRoom uav_room(start);
    Xoshiro256 random(7);
    std::size_t collected = 0;
    for (int step = 0; step < 3000; ++step) {
      const auto action = static_cast<std::uint32_t>(random.below(5));
      collected += uav_room.step(action < 3 ? action : kMove, random).reward == 20.0 ? 1 : 0;
      const RoomMap now = uav_room.map();
      ASSERT_EQ(uav_room.code(), UavRoom(now).code()) << "step " << step;
      ASSERT_EQ(pieces(now), pieces(start)) << "step " << step;
      ASSERT_EQ(now.cells[now.starts.front().cell], Cell::free) << "step " << step;
    }
    EXPECT_GT(collected, 20U);
    uav_room.reset(0);
    EXPECT_EQ(uav_room.map().cells, start.cells);
    EXPECT_EQ(uav_room.cell(), start.starts.front().cell);
    EXPECT_EQ(uav_room.heading(), start.starts.front().heading);
    EXPECT_EQ(uav_room.code(), UavRoom(start).code());
  }
}

TEST(UavRoom, HasAVocabularyThatHolds) {
  const Vocabulary vocabulary = UavRoom::vocabulary();
  EXPECT_TRUE(check_vocabulary(vocabulary).has_value());
  EXPECT_EQ(vocabulary.actions, (std::vector<std::string>{"move", "turn_left", "turn_right"}));
  ASSERT_EQ(vocabulary.features.size(), 8U);
  for (const Feature& feature : vocabulary.features) {
    EXPECT_EQ(feature.values, (std::vector<std::uint8_t>{0, 1, 3}));
    EXPECT_TRUE(feature.admits(Op::equal));
    EXPECT_FALSE(feature.admits(Op::less_equal));
  }
  EXPECT_EQ(vocabulary.find_feature("s7"), 7U);
}

}  // namespace
}  // namespace coppice
