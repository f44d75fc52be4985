// A world that an agent learns in, as data: which one and, for rooms, the map. A study keeps it, so that a tree
// can be tried in the simulator long after the policy was learned. The simulators themselves are uav_room.hpp,
// battery_room.hpp and windy_grid.hpp, or a child process (external_simulator.hpp); learn.hpp and simulate.hpp are what
// the rest of the coordinator calls.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "common/error.hpp"
#include "common/named.hpp"
#include "common/tree/vocabulary.hpp"

namespace coppice {

inline constexpr std::uint32_t kMaxEpisodeSteps = 1'000'000;

enum class WorldKind : std::uint8_t { uav = 0, windy = 1, outside = 2, battery = 3 };
template <>
inline constexpr std::array kNames<WorldKind> = names("uav", "windy", "simulator", "battery");

struct World {
  WorldKind kind = WorldKind::uav;
  std::string room;            // uav, battery: the map as text (room_map.hpp); else empty
  std::string simulator = {};  // outside: the command of the problem's own simulator (external_simulator.hpp)
  Vocabulary vocabulary = {};  // outside: what it is expected to speak
  bool operator==(const World&) const = default;
};

// "uav" (the default room), "battery" (a room with a charger), "windy", or the path of a .room file: with a charger its
// kind is battery, else uav. Errors name file, line and column.
Result<World> load_world(const std::string& name_or_path);

// The kind of a study whose chain was made up (synthetic_chain.hpp): make_world() refuses it, saying so.
inline constexpr const char* kNoWorld = "synthetic";

// As load_world() for what a study holds: kind by name ("uav", "battery" or "windy") and room text.
Result<World> make_world(const std::string& kind, const std::string& room);

// A problem's own simulator. Nothing is started.
World outside_world(const std::string& simulator, const Vocabulary& vocabulary);

Vocabulary vocabulary_of(const World& world);

}  // namespace coppice
