// A room of trash (uav_room.hpp) in which the UAV has a battery and a place to charge: what the thesis wishes for in
// its Chapter 7, "a battery indication on the UAV and a charge location in the environment". The map has one charger
// (room_map.hpp); trash may lie on it.
//
// Actions: those of the room, and charge. The battery holds kCapacity steps and is full when an episode starts; every
// step takes one, whatever the action. `charge` on the charger gives back kChargeStep, up to full, at no reward;
// anywhere else it is a step lost, at -1. With the last step of the battery the UAV falls: the episode ends, at
// kFallReward in place of what the step would have given. A fall and a wall both count as collisions: neither may
// happen.
//
// Observed besides the eight sensors, which do not show the charger:
//   battery  0 to 4, how full the battery is: in fifths, so that neighbouring states look alike
//   charger  where a beacon on the charger is heard: 0 here, 1 ahead, 2 right, 3 behind, 4 left; along the longer of
//   the
//            two distances, ahead or behind when they are equal
//
// An observation is a code: the room's, then battery, then charger.
//
// Owns its whole state; one owner, one thread; copies are independent.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/tree/vocabulary.hpp"
#include "coordinator/learning/outcome.hpp"
#include "coordinator/learning/room_map.hpp"
#include "coordinator/learning/uav_room.hpp"

namespace coppice {

class BatteryRoom {
 public:
  static constexpr std::size_t kActions = UavRoom::kActions + 1;
  static constexpr std::uint32_t kCharge = UavRoom::kActions;  // the action
  static constexpr std::uint32_t kCapacity = 100;              // steps
  static constexpr std::uint32_t kChargeStep = 25;             // steps
  static constexpr double kFallReward = -100.0;
  static constexpr double kWastedReward = -1.0;  // charging where there is no charger
  static constexpr std::uint32_t kLevels = 5;
  static constexpr std::uint32_t kBearings = 5;
  static constexpr std::size_t kCodes = UavRoom::kCodes * kLevels * kBearings;
  static constexpr std::size_t kFeatures = UavRoom::kSensors + 2;
  // A pair may or may not be one, by how full the battery is within its fifth, so the chain has to count them.
  static constexpr bool kCollisionsAreCounted = true;

  // REQUIRES: map.charger.
  explicit BatteryRoom(const RoomMap& map);

  static Vocabulary vocabulary();

  // Writes s0 to s7, battery, charger. REQUIRES: code < kCodes, features.size() == kFeatures.
  static void features_of(std::uint32_t code, std::span<std::uint8_t> features);

  // The inverse of features_of(). REQUIRES: readings that the vocabulary lists.
  static std::uint32_t code_of(std::span<const std::uint8_t> features);

  std::uint32_t starts() const { return room_.starts(); }

  // Back to the map as drawn, at one of its starts, with a full battery. REQUIRES: start < starts().
  void reset(std::uint32_t start) {
    room_.reset(start);
    battery_ = kCapacity;
  }

  // What the UAV observes now, below kCodes. After a fall: as with one step left.
  std::uint32_t code() const {
    const std::uint32_t level = (std::max(battery_, 1U) - 1) * kLevels / kCapacity;
    return room_.code() + static_cast<std::uint32_t>(UavRoom::kCodes) * (level + kLevels * bearing());
  }

  // Random: below(n), uniform in [0, n). REQUIRES: action < kActions, no fall since reset().
  template <typename Random>
  Outcome step(std::uint32_t action, Random& random) {
    Outcome outcome;
    --battery_;
    if (action != kCharge) {
      outcome = room_.step(action, random);
    } else if (bearing() == 0) {
      battery_ = std::min(battery_ + kChargeStep, kCapacity);
    } else {
      outcome.reward = kWastedReward;
    }
    return battery_ == 0 ? Outcome{.reward = kFallReward, .collided = true, .ended = true} : outcome;
  }

  // Steps left.
  std::uint32_t battery() const { return battery_; }
  RoomMap map() const { return room_.map(); }

 private:
  std::uint8_t bearing() const {
    return bearings_[room_.cell() * kHeadings + static_cast<std::size_t>(room_.heading())];
  }

  UavRoom room_;
  std::vector<std::uint8_t> bearings_;  // [cells x headings]
  std::uint32_t battery_ = kCapacity;
};

}  // namespace coppice
