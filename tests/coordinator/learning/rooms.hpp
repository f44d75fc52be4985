// Rooms that several tests share.
#pragma once

#include <string>
#include <vector>

#include "coordinator/learning/room_map.hpp"
#include "coordinator/learning/world.hpp"

namespace coppice::testing {

inline std::string joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) {
    text += line + "\n";
  }
  return text;
}

// REQUIRES: a well-formed room.
inline RoomMap room(const std::vector<std::string>& lines) { return parse_room(joined(lines)).value(); }
inline World world(const std::vector<std::string>& lines) { return make_world("uav", joined(lines)).value(); }

// A room with an obstacle, several pieces of trash and every sort of corner, small enough to learn in a moment.
inline std::vector<std::string> small_room() {
  return {
      "#########",  //
      "#.......#",  //
      "#.*...*.#",  //
      "#...#...#",  //
      "#.*.#.*.#",  //
      "#.......#",  //
      "#^..*...#",  //
      "#########",
  };
}

}  // namespace coppice::testing
