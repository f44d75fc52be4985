#include "coordinator/learning/room_map.hpp"

#include <gtest/gtest.h>
#include <ostream>
#include <random>

#include "tests/coordinator/learning/rooms.hpp"

namespace coppice {
namespace {

using testing::joined;

TEST(RoomMap, ReadsCellsAndTheUav) {
  const auto map = parse_room(joined({"#####", "#.*.#", "#.>*#", "#####"}));
  ASSERT_TRUE(map.has_value()) << map.error().message;
  EXPECT_EQ(map->width, 5U);
  EXPECT_EQ(map->height, 4U);
  EXPECT_EQ(map->starts.front().cell, 12U);
  EXPECT_EQ(map->starts.front().heading, Heading::right);
  EXPECT_EQ(map->cells[0], Cell::wall);
  EXPECT_EQ(map->cells[6], Cell::free);
  EXPECT_EQ(map->cells[7], Cell::trash);
  EXPECT_EQ(map->cells[12], Cell::free);
  EXPECT_EQ(map->cells[13], Cell::trash);
}

TEST(RoomMap, ReadsEveryHeading) {
  const std::string marks = "^>v<";
  for (std::size_t heading = 0; heading < kHeadings; ++heading) {
    const auto map = parse_room(joined({"###", std::string("#") + marks[heading] + "#", "###"}));
    ASSERT_TRUE(map.has_value()) << map.error().message;
    EXPECT_EQ(static_cast<std::size_t>(map->starts.front().heading), heading);
  }
}

TEST(RoomMap, ReadsSeveralStartsAndACharger) {
  const auto map = parse_room("#####\n#^.C#\n##.v#\n#####\n");
  ASSERT_TRUE(map.has_value()) << map.error().message;
  EXPECT_EQ(map->starts, (std::vector<RoomStart>{{6, Heading::up}, {13, Heading::down}}));
  EXPECT_EQ(map->charger, 8U);
  EXPECT_EQ(map->cells[8], Cell::free);
  EXPECT_FALSE(parse_room("###\n#^#\n###\n")->charger.has_value());
}

TEST(RoomMap, AcceptsBlankLinesAtTheEndAndForeignLineEnds) {
  EXPECT_TRUE(parse_room("###\n#^#\n###").has_value());
  EXPECT_TRUE(parse_room("###\n#^#\n###\n\n\n").has_value());
  EXPECT_TRUE(parse_room("###\r\n#^#\r\n###\r\n\r\n").has_value());
}

TEST(RoomMap, AcceptsTheLargestRoom) {
  std::vector<std::string> lines(kMaxRoomSide, "#" + std::string(kMaxRoomSide - 2, '.') + "#");
  lines.front() = lines.back() = std::string(kMaxRoomSide, '#');
  lines[100][100] = 'v';
  EXPECT_TRUE(parse_room(joined(lines)).has_value());
}

struct BadRoom {
  const char* what;
  std::string text;
  std::vector<std::string> expected;  // all of these in the message
};

// What a test's name shows.
std::ostream& operator<<(std::ostream& out, const BadRoom& room) { return out << room.what; }

class RoomMapRefuses : public ::testing::TestWithParam<BadRoom> {};

TEST_P(RoomMapRefuses, NamingThePlace) {
  const auto map = parse_room(GetParam().text);
  ASSERT_FALSE(map.has_value());
  EXPECT_EQ(map.error().kind, ErrorKind::bad_input);
  for (const std::string& expected : GetParam().expected) {
    EXPECT_NE(map.error().message.find(expected), std::string::npos) << map.error().message;
  }
  EXPECT_EQ(map.error().message.find('\n'), std::string::npos) << map.error().message;
}

INSTANTIATE_TEST_SUITE_P(
    RoomMap, RoomMapRefuses,
    ::testing::Values(
        BadRoom{"nothing", "", {"line 1", "3 to 256"}}, BadRoom{"two_lines", "###\n###\n", {"line 3", "2 lines"}},
        BadRoom{"short_line", "#####\n#.^.#\n#..#\n#####\n", {"line 3, column 5", "4 cells", "expected 5"}},
        BadRoom{"long_line", "#####\n#.^.#\n#...##\n#####\n", {"line 3, column 6", "6 cells", "expected 5"}},
        BadRoom{"blank_line_inside", "###\n\n#^#\n###\n", {"line 2, column 1", "0 cells"}},
        BadRoom{"unknown_character", "#####\n#.^x#\n#####\n", {"line 2, column 4", "'x'", "expected"}},
        BadRoom{"binary", std::string("#####\n#.^\x01#\n#####\n"), {"line 2, column 4", "'\\x01'"}},
        BadRoom{"no_uav", "#####\n#...#\n#####\n", {"no UAV", "^ > v <"}},
        BadRoom{"two_chargers", "#####\n#^CC#\n#####\n", {"line 2, column 4", "second charger", "line 2, column 3"}},
        BadRoom{"open_top", "##.##\n#.^.#\n#####\n", {"line 1, column 3", "border"}},
        BadRoom{"open_side", "#####\n#.^..\n#####\n", {"line 2, column 5", "border"}},
        BadRoom{"uav_in_the_wall", "#####\n#...#\n##^##\n", {"line 3, column 3", "border"}},
        BadRoom{"unreachable_cell", "######\n#^.#.#\n######\n", {"line 2, column 5", "reach"}},
        BadRoom{"too_narrow", "##\n##\n##\n", {"line 1", "2 cells wide"}},
        BadRoom{"too_wide",
                joined({std::string(257, '#'), std::string(257, '#'), std::string(257, '#')}),
                {"line 1", "257 cells wide"}},
        BadRoom{"too_high", joined(std::vector<std::string>(257, "###")), {"line 257", "too high"}}),
    [](const auto& bad) { return bad.param.what; });

TEST(RoomMap, NeverFailsButWithAMessageOnArbitraryText) {
  std::mt19937_64 random(1);
  const std::string marks = "###....**^>v<C\n\n\r x";
  for (int i = 0; i < 20000; ++i) {
    std::string text;
    const std::size_t length = random() % 60;
    for (std::size_t k = 0; k < length; ++k) {
      text += marks[random() % marks.size()];
    }
    const auto map = parse_room(text);
    if (map) {
      EXPECT_EQ(map->cells.size(), map->width * map->height);
      EXPECT_EQ(map->cells[map->starts.front().cell], Cell::free);
    } else {
      EXPECT_FALSE(map.error().message.empty());
    }
  }
}

}  // namespace
}  // namespace coppice
