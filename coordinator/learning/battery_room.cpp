#include "coordinator/learning/battery_room.hpp"

#include <cstdlib>
#include <numeric>
#include <string>

#include "common/check.hpp"

namespace coppice {
namespace {

// Of the charger, seen from a cell (dx to the right on the map, dy downwards) under a heading.
std::uint8_t bearing_of(int dx, int dy, Heading heading) {
  int ahead = -dy;
  int right = dx;
  for (std::uint32_t turn = 0; turn < static_cast<std::uint32_t>(heading); ++turn) {
    const int before = ahead;  // a turn to the right: what was on the right lies ahead, what was ahead on the left
    ahead = right;
    right = -before;
  }
  if (ahead == 0 && right == 0) {
    return 0;
  }
  if (std::abs(ahead) >= std::abs(right)) {
    return ahead > 0 ? 1 : 3;
  }
  return right > 0 ? 2 : 4;
}

}  // namespace

BatteryRoom::BatteryRoom(const RoomMap& map) : room_(map) {
  COPPICE_CHECK(map.charger.has_value());
  const auto width = static_cast<int>(map.width);
  const auto charger = static_cast<int>(*map.charger);
  bearings_.reserve(map.cells.size() * kHeadings);
  for (int cell = 0; cell < static_cast<int>(map.cells.size()); ++cell) {
    for (std::uint32_t heading = 0; heading < kHeadings; ++heading) {
      bearings_.push_back(
          bearing_of(charger % width - cell % width, charger / width - cell / width, static_cast<Heading>(heading)));
    }
  }
}

Vocabulary BatteryRoom::vocabulary() {
  Vocabulary vocabulary = UavRoom::vocabulary();
  std::vector<std::uint8_t> levels(kLevels);
  std::iota(levels.begin(), levels.end(), std::uint8_t{0});
  std::vector<std::uint8_t> bearings(kBearings);
  std::iota(bearings.begin(), bearings.end(), std::uint8_t{0});
  vocabulary.features.push_back({"battery", std::move(levels), true, true});
  vocabulary.features.push_back({"charger", std::move(bearings), true, false});
  vocabulary.actions.emplace_back("charge");
  return vocabulary;
}

void BatteryRoom::features_of(std::uint32_t code, std::span<std::uint8_t> features) {
  COPPICE_CHECK(code < kCodes && features.size() == kFeatures);
  UavRoom::features_of(code % UavRoom::kCodes, features.first(UavRoom::kSensors));
  const auto rest = code / static_cast<std::uint32_t>(UavRoom::kCodes);
  features[UavRoom::kSensors] = static_cast<std::uint8_t>(rest % kLevels);
  features[UavRoom::kSensors + 1] = static_cast<std::uint8_t>(rest / kLevels);
}

std::uint32_t BatteryRoom::code_of(std::span<const std::uint8_t> features) {
  COPPICE_CHECK(features.size() == kFeatures);
  const std::uint32_t level = features[UavRoom::kSensors];
  const std::uint32_t bearing = features[UavRoom::kSensors + 1];
  COPPICE_CHECK(level < kLevels && bearing < kBearings);
  return UavRoom::code_of(features.first(UavRoom::kSensors)) +
         static_cast<std::uint32_t>(UavRoom::kCodes) * (level + kLevels * bearing);
}

}  // namespace coppice
