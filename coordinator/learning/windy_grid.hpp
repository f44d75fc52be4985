// The windy grid world of thesis Chapter 4 (after Sutton and Barto 1998, Example 6.5): 10 columns, x = 0..9 from the
// left, and 8 rows, y = 0..7 from the top. The agent starts in (0, 3) and wants to (7, 3); in column x the wind blows
// it up by kWind[x] rows, the column being the one that it leaves. At the border it stays in the grid, without
// extra cost. The shortest way takes 15 steps.
//
// Actions: up, down, left, right. Reward: -1 a step, and +10 on reaching the goal, which ends the episode (that step
// gives 9).
//
// The thesis prints neither coordinates nor the wind: start, goal and wind are Sutton and Barto's, whose grid has seven
// rows; the eighth is added at the bottom, where it leaves the shortest way as it is. The thesis also ends an episode
// at a collected reward of -25, which is its limit of 25 steps over again; here the step limit alone does that.
//
// Owns its whole state; one owner, one thread; copies are independent.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "common/tree/vocabulary.hpp"
#include "coordinator/learning/outcome.hpp"

namespace coppice {

class WindyGrid {
 public:
  static constexpr std::size_t kActions = 4;
  static constexpr int kColumns = 10;
  static constexpr int kRows = 8;
  static constexpr std::size_t kCodes = 80;  // kColumns * kRows
  static constexpr std::array<int, 10> kWind{0, 0, 0, 1, 1, 1, 2, 2, 1, 0};
  struct Place {
    int x = 0;
    int y = 0;
    bool operator==(const Place&) const = default;
  };
  static constexpr Place kStart{0, 3};
  static constexpr Place kGoal{7, 3};

  static Vocabulary vocabulary();

  // Writes x and y. REQUIRES: code < kCodes, features.size() == 2.
  static void features_of(std::uint32_t code, std::span<std::uint8_t> features);

  // The inverse of features_of(). REQUIRES: x and y within the grid.
  static std::uint32_t code_of(std::span<const std::uint8_t> features);

  static constexpr std::uint32_t starts() { return 1; }

  void reset(std::uint32_t /*start*/) { place_ = kStart; }

  std::uint32_t code() const { return static_cast<std::uint32_t>(place_.y * kColumns + place_.x); }

  // REQUIRES: action < kActions.
  template <typename Random>
  Outcome step(std::uint32_t action, Random& /*nothing here is left to chance*/) {
    constexpr std::array<Place, kActions> kMove{{{0, -1}, {0, 1}, {-1, 0}, {1, 0}}};
    const int wind = kWind[static_cast<std::size_t>(place_.x)];
    place_ = {std::clamp(place_.x + kMove[action].x, 0, kColumns - 1),
              std::clamp(place_.y + kMove[action].y - wind, 0, kRows - 1)};
    const bool reached = place_ == kGoal;
    return {reached ? 9.0 : -1.0, false, reached};
  }

  Place place() const { return place_; }

 private:
  Place place_ = kStart;
};

}  // namespace coppice
