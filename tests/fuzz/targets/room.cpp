// parse_room(): whatever it accepts keeps what room_map.hpp promises, reads back from a drawing of it, and can be flown
// in without losing a piece of trash.
#include <algorithm>
#include <array>

#include "common/chain/random.hpp"
#include "common/check.hpp"
#include "coordinator/learning/room_map.hpp"
#include "coordinator/learning/uav_room.hpp"
#include "coordinator/learning/world.hpp"
#include "tests/fuzz/target.hpp"

namespace coppice::fuzz {
namespace {

constexpr int kSteps = 64;

std::string draw(const RoomMap& map) {
  constexpr std::string_view kHeadingMarks = "^>v<";
  std::string text;
  for (std::size_t cell = 0; cell < map.cells.size(); ++cell) {
    if (cell == map.uav_cell) {
      text += kHeadingMarks[static_cast<std::size_t>(map.uav_heading)];
    } else {
      text += map.cells[cell] == Cell::wall ? '#' : map.cells[cell] == Cell::trash ? '*' : '.';
    }
    if ((cell + 1) % map.width == 0) {
      text += '\n';
    }
  }
  return text;
}

bool same(const RoomMap& a, const RoomMap& b) {
  return a.width == b.width && a.height == b.height && a.cells == b.cells && a.uav_cell == b.uav_cell &&
         a.uav_heading == b.uav_heading;
}

auto pieces(const RoomMap& map) { return std::count(map.cells.begin(), map.cells.end(), Cell::trash); }

void check_map(const RoomMap& map) {
  COPPICE_CHECK(map.width >= kMinRoomSide && map.width <= kMaxRoomSide);
  COPPICE_CHECK(map.height >= kMinRoomSide && map.height <= kMaxRoomSide);
  COPPICE_CHECK(map.cells.size() == map.width * map.height);
  COPPICE_CHECK(map.uav_cell < map.cells.size() && map.cells[map.uav_cell] == Cell::free);
  for (std::size_t row = 0; row < map.height; ++row) {
    for (std::size_t column = 0; column < map.width; ++column) {
      const bool border = row == 0 || column == 0 || row + 1 == map.height || column + 1 == map.width;
      COPPICE_CHECK(!border || map.cells[row * map.width + column] == Cell::wall);
    }
  }
}

void fly(const RoomMap& map) {
  UavRoom room(map);
  COPPICE_CHECK(same(room.map(), map));
  Xoshiro256 random(1);
  for (int step = 0; step < kSteps; ++step) {
    room.step(static_cast<std::uint32_t>(random.below(UavRoom::kActions)), random);
    COPPICE_CHECK(room.code() < UavRoom::kCodes);
  }
  const RoomMap after = room.map();
  COPPICE_CHECK(pieces(after) == pieces(map));
  const auto drawn = parse_room(draw(after));
  COPPICE_CHECK(drawn.has_value() && same(*drawn, after));
  // What was kept up to date along the way is what a new simulator sees.
  COPPICE_CHECK(UavRoom(after).code() == room.code());
  room.reset();
  COPPICE_CHECK(same(room.map(), map));
}

void test(std::string_view text) {
  const auto map = parse_room(text);
  accepted = map.has_value();
  COPPICE_CHECK(make_world("uav", std::string(text)).has_value() == accepted);
  if (!map) {
    COPPICE_CHECK(is_printable_refusal(map.error()));
    return;
  }
  check_map(*map);
  const auto again = parse_room(draw(*map));
  COPPICE_CHECK(again.has_value() && same(*again, *map));
  fly(*map);
}

}  // namespace
}  // namespace coppice::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  coppice::fuzz::test(coppice::fuzz::as_text(data, size));
  return 0;
}
