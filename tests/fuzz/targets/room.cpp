// parse_room(): whatever it accepts keeps what room_map.hpp promises, reads back from a drawing of it, and can be flown
// in without losing a piece of trash.
#include <algorithm>
#include <array>

#include "common/chain/random.hpp"
#include "common/check.hpp"
#include "coordinator/learning/battery_room.hpp"
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
    const auto start = std::find_if(map.starts.begin(), map.starts.end(),
                                    [&](const RoomStart& candidate) { return candidate.cell == cell; });
    if (start != map.starts.end()) {
      text += kHeadingMarks[static_cast<std::size_t>(start->heading)];
    } else if (map.charger == cell && map.cells[cell] == Cell::free) {
      text += 'C';
    } else {
      text += map.cells[cell] == Cell::wall ? '#' : map.cells[cell] == Cell::trash ? '*' : '.';
    }
    if ((cell + 1) % map.width == 0) {
      text += '\n';
    }
  }
  return text;
}

auto pieces(const RoomMap& map) { return std::count(map.cells.begin(), map.cells.end(), Cell::trash); }

void check_map(const RoomMap& map) {
  COPPICE_CHECK(map.width >= kMinRoomSide && map.width <= kMaxRoomSide);
  COPPICE_CHECK(map.height >= kMinRoomSide && map.height <= kMaxRoomSide);
  COPPICE_CHECK(map.cells.size() == map.width * map.height);
  COPPICE_CHECK(!map.starts.empty());
  for (const RoomStart& start : map.starts) {
    COPPICE_CHECK(start.cell < map.cells.size() && map.cells[start.cell] == Cell::free);
  }
  COPPICE_CHECK(!map.charger || (*map.charger < map.cells.size() && map.cells[*map.charger] == Cell::free));
  for (std::size_t row = 0; row < map.height; ++row) {
    for (std::size_t column = 0; column < map.width; ++column) {
      const bool border = row == 0 || column == 0 || row + 1 == map.height || column + 1 == map.width;
      COPPICE_CHECK(!border || map.cells[row * map.width + column] == Cell::wall);
    }
  }
}

// As drawn, but that the UAV stands at one of its starts.
bool is_start_of(const RoomMap& now, const RoomMap& map, std::size_t start) {
  return now.cells == map.cells && now.starts == std::vector<RoomStart>{map.starts[start]} &&
         now.charger == map.charger;
}

void fly(const RoomMap& map) {
  UavRoom room(map);
  COPPICE_CHECK(is_start_of(room.map(), map, 0) && room.starts() == map.starts.size());
  Xoshiro256 random(1);
  for (int step = 0; step < kSteps; ++step) {
    room.step(static_cast<std::uint32_t>(random.below(UavRoom::kActions)), random);
    COPPICE_CHECK(room.code() < UavRoom::kCodes);
  }
  RoomMap after = room.map();
  COPPICE_CHECK(pieces(after) == pieces(map));
  // A drawing has one mark a cell, so a charger under the UAV or under trash is not drawn.
  after.charger.reset();
  const auto drawn = parse_room(draw(after));
  COPPICE_CHECK(drawn.has_value() && *drawn == after);
  // What was kept up to date along the way is what a new simulator sees.
  COPPICE_CHECK(UavRoom(after).code() == room.code());
  room.reset(room.starts() - 1);
  COPPICE_CHECK(is_start_of(room.map(), map, map.starts.size() - 1));
}

void fly_on_battery(const RoomMap& map) {
  BatteryRoom room(map);
  Xoshiro256 random(1);
  for (std::uint32_t step = 0; step < 2 * BatteryRoom::kCapacity; ++step) {
    const Outcome outcome = room.step(static_cast<std::uint32_t>(random.below(BatteryRoom::kActions)), random);
    COPPICE_CHECK(room.code() < BatteryRoom::kCodes && room.battery() <= BatteryRoom::kCapacity);
    COPPICE_CHECK(outcome.ended == (room.battery() == 0));
    if (outcome.ended) {
      room.reset(0);
    }
  }
}

void test(std::string_view text) {
  const auto map = parse_room(text);
  accepted = map.has_value();
  const bool charger = accepted && map->charger;
  COPPICE_CHECK(make_world("uav", std::string(text)).has_value() == (accepted && !charger));
  COPPICE_CHECK(make_world("battery", std::string(text)).has_value() == charger);
  if (!map) {
    COPPICE_CHECK(is_printable_refusal(map.error()));
    return;
  }
  check_map(*map);
  const auto again = parse_room(draw(*map));
  COPPICE_CHECK(again.has_value() && *again == *map);
  fly(*map);
  if (map->charger) {
    fly_on_battery(*map);
  }
}

}  // namespace
}  // namespace coppice::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  coppice::fuzz::test(coppice::fuzz::as_text(data, size));
  return 0;
}
