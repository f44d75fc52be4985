#include "coordinator/learning/world.hpp"

#include <fmt/format.h>
#include <fstream>
#include <utility>

#include "coordinator/learning/battery_room.hpp"
#include "coordinator/learning/room_map.hpp"
#include "coordinator/learning/rooms.hpp"
#include "coordinator/learning/uav_room.hpp"
#include "coordinator/learning/windy_grid.hpp"

namespace coppice {
namespace {

// A room of the largest size with CR LF line ends, and as much again for blank lines at the end.
constexpr std::size_t kMaxRoomBytes = 2 * kMaxRoomSide * (kMaxRoomSide + 2);

Result<std::string> read_room_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    return bad_input(fmt::format(
        "world '{}': cannot open: expected \"uav\", \"battery\", \"windy\" or the path of a .room file", path));
  }
  std::string text(kMaxRoomBytes + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (file.bad() || (file.fail() && !file.eof())) {
    return bad_input(fmt::format("world '{}': cannot be read: expected a .room file", path));
  }
  text.resize(static_cast<std::size_t>(file.gcount()));
  if (text.size() > kMaxRoomBytes) {
    return bad_input(fmt::format("{}: more than {} bytes: expected a room of at most {} x {} cells", path,
                                 kMaxRoomBytes, kMaxRoomSide, kMaxRoomSide));
  }
  return text;
}

}  // namespace

Result<World> load_world(const std::string& name_or_path) {
  if (name_or_path == name_of(WorldKind::uav)) {
    return World{WorldKind::uav, std::string(default_room()), {}, {}};
  }
  if (name_or_path == name_of(WorldKind::battery)) {
    return World{WorldKind::battery, std::string(battery_room()), {}, {}};
  }
  if (name_or_path == name_of(WorldKind::windy)) {
    return World{WorldKind::windy, {}, {}, {}};
  }
  auto text = read_room_file(name_or_path);
  if (!text) {
    return tl::unexpected(text.error());
  }
  const auto map = parse_room(*text);
  if (!map) {
    return in_context(name_or_path, map.error());
  }
  return World{map->charger ? WorldKind::battery : WorldKind::uav, std::move(*text), {}, {}};
}

Result<World> make_world(const std::string& kind, const std::string& room) {
  if (kind == kNoWorld) {
    return bad_input("the study has no world to simulate: expected --simulator, or a study of 'coppice learn'");
  }
  if (kind == name_of(WorldKind::windy)) {
    if (!room.empty()) {
      return bad_input(fmt::format("world 'windy': a map of {} bytes: expected none", room.size()));
    }
    return World{WorldKind::windy, {}, {}, {}};
  }
  const bool battery = kind == name_of(WorldKind::battery);
  if (!battery && kind != name_of(WorldKind::uav)) {
    return bad_input(fmt::format("world kind '{}': expected \"uav\", \"battery\" or \"windy\"", kind));
  }
  const auto map = parse_room(room);
  if (!map) {
    return tl::unexpected(map.error());
  }
  if (battery != map->charger.has_value()) {
    return bad_input(fmt::format("world '{}': its map has {} charger: expected {}", kind, map->charger ? "a" : "no",
                                 battery ? "one" : "none"));
  }
  return World{battery ? WorldKind::battery : WorldKind::uav, room, {}, {}};
}

World outside_world(const std::string& simulator, const Vocabulary& vocabulary) {
  return {WorldKind::outside, {}, simulator, vocabulary};
}

Vocabulary vocabulary_of(const World& world) {
  switch (world.kind) {
    case WorldKind::uav:
      return UavRoom::vocabulary();
    case WorldKind::battery:
      return BatteryRoom::vocabulary();
    case WorldKind::windy:
      return WindyGrid::vocabulary();
    case WorldKind::outside:
      break;
  }
  return world.vocabulary;
}

}  // namespace coppice
