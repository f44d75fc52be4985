// A room as drawn in a .room file: one character a cell, one line a row.
//   #  wall    .  free    *  trash    ^ > v <  the UAV and its heading (once)
// A checked value: rectangular, within kMaxRoomSide, its border all wall, exactly one UAV, and every cell that is not
// a wall can be reached by the UAV (trash would otherwise drain into cells where nobody can collect it). Immutable once
// parsed; safe to share between threads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "common/error.hpp"

namespace coppice {

inline constexpr std::size_t kMinRoomSide = 3;    // a border and one cell
inline constexpr std::size_t kMaxRoomSide = 256;  // cells

enum class Cell : std::uint8_t { wall = 0, free = 1, trash = 2 };

// Clockwise, so that turning right adds one.
enum class Heading : std::uint8_t { up = 0, right = 1, down = 2, left = 3 };
inline constexpr std::uint32_t kHeadings = 4;

struct RoomMap {
  std::size_t width = 0;
  std::size_t height = 0;
  std::vector<Cell> cells;  // [height x width], row-major, top row first; the UAV's cell is free
  std::size_t uav_cell = 0;
  Heading uav_heading = Heading::up;
};

// Blank lines at the end and CR LF line ends are accepted. Errors name line and column (from 1), what was found
// and what was expected. Never throws on any input.
Result<RoomMap> parse_room(std::string_view text);

}  // namespace coppice
