// A room as drawn in a .room file: one character a cell, one line a row.
//   #  wall    .  free    *  trash    C  the charger, at most one    ^ > v <  the UAV and its heading, once or more:
// an episode starts at one of these places, each as likely as the others
// A checked value: rectangular (what lies outside a room of another shape is drawn as wall), within kMaxRoomSide, its
// border all wall, at least one start, and every cell that is not a wall can be reached from it (trash would otherwise
// drain into cells where nobody can collect it). Immutable once parsed; safe to share between threads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
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

struct RoomStart {
  std::size_t cell = 0;
  Heading heading = Heading::up;
  bool operator==(const RoomStart&) const = default;
};

struct RoomMap {
  std::size_t width = 0;
  std::size_t height = 0;
  std::vector<Cell> cells;             // [height x width], row-major, top row first; starts and charger are free
  std::vector<RoomStart> starts;       // in reading order, at least one
  std::optional<std::size_t> charger;  // a cell
  bool operator==(const RoomMap&) const = default;
};

// Blank lines at the end and CR LF line ends are accepted. Errors name line and column (from 1), what was found
// and what was expected. Never throws on any input.
Result<RoomMap> parse_room(std::string_view text);

}  // namespace coppice
