// From a world, which is data, to its simulator: the one place that knows which class belongs to which world. What
// every simulator has: kActions, kCodes, vocabulary(), features_of(code, features), code_of(features), starts(),
// reset(start), code(), step(action, random).
#pragma once

#include <utility>

#include "common/check.hpp"
#include "coordinator/learning/battery_room.hpp"
#include "coordinator/learning/room_map.hpp"
#include "coordinator/learning/uav_room.hpp"
#include "coordinator/learning/windy_grid.hpp"
#include "coordinator/learning/world.hpp"

namespace coppice {

// visit(simulator), called once with a new one. REQUIRES: a world from make_world() or load_world(), not outside.
template <typename Visit>
auto with_simulator(const World& world, const Visit& visit) {
  COPPICE_CHECK(world.kind != WorldKind::outside);
  if (world.kind == WorldKind::windy) {
    return visit(WindyGrid());
  }
  const Result<RoomMap> map = parse_room(world.room);
  COPPICE_CHECK(map.has_value());
  return world.kind == WorldKind::battery ? visit(BatteryRoom(*map)) : visit(UavRoom(*map));
}

// Which start an episode has. One start draws nothing.
template <typename Random>
std::uint32_t draw_start(std::uint32_t starts, Random& random) {
  return starts == 1 ? 0 : static_cast<std::uint32_t>(random.below(starts));
}

}  // namespace coppice
