#include "coordinator/learning/room_map.hpp"

#include <fmt/format.h>
#include <optional>

namespace coppice {
namespace {

constexpr std::string_view kHeadingMarks = "^>v<";  // in the order of Heading
constexpr char kChargerMark = 'C';

std::string quoted(char c) {
  const auto byte = static_cast<unsigned char>(c);
  return byte >= 0x20 && byte < 0x7F ? fmt::format("'{}'", c) : fmt::format("'\\x{:02X}'", byte);
}

std::string at(std::size_t line, std::size_t column) { return fmt::format("line {}, column {}", line, column); }

Result<std::vector<std::string_view>> lines_of(std::string_view text) {
  std::vector<std::string_view> lines;
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    std::string_view line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    if (!line.empty() && line.back() == '\r') {
      line.remove_suffix(1);
    }
    if (line.empty() && text.find_first_not_of("\r\n") == std::string_view::npos) {
      break;
    }
    lines.push_back(line);
    if (lines.size() > kMaxRoomSide) {
      return bad_input(fmt::format("line {}: the room is too high: expected {} to {} lines", lines.size(), kMinRoomSide,
                                   kMaxRoomSide));
    }
  }
  if (lines.size() < kMinRoomSide) {
    return bad_input(fmt::format("line {}: the room ends after {} lines: expected {} to {}", lines.size() + 1,
                                 lines.size(), kMinRoomSide, kMaxRoomSide));
  }
  return lines;
}

Result<void> check_width(const std::vector<std::string_view>& lines) {
  const std::size_t width = lines.front().size();
  if (width < kMinRoomSide || width > kMaxRoomSide) {
    return bad_input(
        fmt::format("line 1: the room is {} cells wide: expected {} to {}", width, kMinRoomSide, kMaxRoomSide));
  }
  for (std::size_t row = 1; row < lines.size(); ++row) {
    const std::size_t found = lines[row].size();
    if (found != width) {
      return bad_input(fmt::format("{}: the line has {} cells: expected {} as in line 1",
                                   at(row + 1, (found < width ? found : width) + 1), found, width));
    }
  }
  return {};
}

// The first cell, in reading order, that is not a wall and that the UAV cannot come to.
std::optional<std::size_t> unreachable_cell(const RoomMap& map) {
  std::vector<bool> reached(map.cells.size(), false);
  std::vector<std::size_t> frontier{map.starts.front().cell};
  reached[frontier.front()] = true;
  while (!frontier.empty()) {
    const std::size_t cell = frontier.back();
    frontier.pop_back();
    for (const std::size_t next : {cell - 1, cell + 1, cell - map.width, cell + map.width}) {
      if (map.cells[next] != Cell::wall && !reached[next]) {
        reached[next] = true;
        frontier.push_back(next);
      }
    }
  }
  for (std::size_t cell = 0; cell < map.cells.size(); ++cell) {
    if (map.cells[cell] != Cell::wall && !reached[cell]) {
      return cell;
    }
  }
  return std::nullopt;
}

Result<RoomMap> read_cells(const std::vector<std::string_view>& lines) {
  RoomMap map{lines.front().size(), lines.size(), {}, {}, {}};
  map.cells.reserve(map.width * map.height);
  for (std::size_t row = 0; row < map.height; ++row) {
    for (std::size_t column = 0; column < map.width; ++column) {
      const char mark = lines[row][column];
      const bool border = row == 0 || column == 0 || row + 1 == map.height || column + 1 == map.width;
      const std::size_t heading = kHeadingMarks.find(mark);
      const bool known =
          mark == '#' || mark == '.' || mark == '*' || mark == kChargerMark || heading != std::string_view::npos;
      if (!known) {
        return bad_input(
            fmt::format("{}: found {}: expected # (wall), . (free), * (trash), C (charger) or the UAV as ^ > v <",
                        at(row + 1, column + 1), quoted(mark)));
      }
      if (border && mark != '#') {
        return bad_input(fmt::format("{}: found {} on the border: expected # (a room is enclosed by walls)",
                                     at(row + 1, column + 1), quoted(mark)));
      }
      if (heading != std::string_view::npos) {
        map.starts.push_back({map.cells.size(), static_cast<Heading>(heading)});
      }
      if (mark == kChargerMark) {
        if (map.charger) {
          return bad_input(fmt::format("{}: found a second charger: expected at most one, and it is at {}",
                                       at(row + 1, column + 1),
                                       at(*map.charger / map.width + 1, *map.charger % map.width + 1)));
        }
        map.charger = map.cells.size();
      }
      map.cells.push_back(mark == '#' ? Cell::wall : mark == '*' ? Cell::trash : Cell::free);
    }
  }
  if (map.starts.empty()) {
    return bad_input(fmt::format("lines 1 to {}: no UAV: expected one of ^ > v <", map.height));
  }
  return map;
}

}  // namespace

Result<RoomMap> parse_room(std::string_view text) {
  const auto lines = lines_of(text);
  if (!lines) {
    return tl::unexpected(lines.error());
  }
  if (auto ok = check_width(*lines); !ok) {
    return tl::unexpected(ok.error());
  }
  auto map = read_cells(*lines);
  if (!map) {
    return map;
  }
  if (const auto cell = unreachable_cell(*map)) {
    return bad_input(fmt::format("{}: the UAV cannot reach this cell: expected # (wall) or an open way to it",
                                 at(*cell / map->width + 1, *cell % map->width + 1)));
  }
  return map;
}

}  // namespace coppice
