// The map of the world named "uav": rooms/default.room, built into the program so that it needs no data file.
#pragma once

#include <string_view>

namespace coppice {

std::string_view default_room();

}  // namespace coppice
