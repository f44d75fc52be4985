// The maps of the worlds named "uav" and "battery": rooms/default.room and rooms/battery.room, built into the program
// so that it needs no data files.
#pragma once

#include <string_view>

namespace coppice {

std::string_view default_room();
std::string_view battery_room();

}  // namespace coppice
