// The problem of our own worlds (coordinator/learning): what their features and actions mean, for studies that do not
// say so themselves.
#pragma once

#include <string_view>

#include "coordinator/problem/problem.hpp"

namespace coppice {

// `kind`: as a study keeps it ("uav", "battery", "windy"). Features that a world does not know stay without a label.
Problem problem_of_world(std::string_view kind, const Vocabulary& vocabulary);

}  // namespace coppice
