// The simulator of the thesis' test case (VI-B to VI-D): a UAV in a room of walls and trash, seeing eight cells.
//
// Actions: move, turn_left, turn_right. Rewards: 0, -1, -1; moving into a wall gives -10 and the UAV stays; moving onto
// trash gives +20, and a new piece appears on a cell drawn uniformly from those that are free (no wall, no trash, not
// the UAV's; there always is one, since the UAV has just left one). So the number of pieces never changes.
//
// Sensors, relative to the heading: s3 ahead, s2 ahead left, s4 ahead right, s1 left, s5 right, s7 two ahead (behind
// s3), s0 two left (behind s1), s6 two right (behind s5). A sensor reads 0 wall, 1 free, 3 trash; behind a wall it
// reads wall.
//
// An observation is a code in base 3, digit i for sensor i (0 wall, 1 free, 2 trash). The codes of every cell, for all
// four headings in one word, are kept up to date when a piece of trash goes or comes, which is rarer by an order of
// magnitude than a step, so that a step itself is a few loads. reset() restores them with one copy: 8 bytes a cell,
// about 3 KB for the default room.
//
// Owns its whole state; one owner, one thread; copies are independent.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/tree/vocabulary.hpp"
#include "coordinator/learning/outcome.hpp"
#include "coordinator/learning/room_map.hpp"

namespace coppice {

class UavRoom {
 public:
  static constexpr std::size_t kActions = 3;
  static constexpr std::array<double, kActions> kReward{0.0, -1.0, -1.0};
  static constexpr double kCollisionReward = -10.0;
  static constexpr double kTrashReward = 20.0;
  static constexpr std::size_t kSensors = 8;
  static constexpr std::size_t kCodes = 6561;  // 3^8

  explicit UavRoom(const RoomMap& map);

  static Vocabulary vocabulary();

  // Writes the readings of s0 to s7. REQUIRES: code < kCodes, features.size() == kSensors.
  static void features_of(std::uint32_t code, std::span<std::uint8_t> features);

  // The inverse of features_of(). REQUIRES: readings that the vocabulary lists.
  static std::uint32_t code_of(std::span<const std::uint8_t> features);

  // How many places an episode can start at.
  std::uint32_t starts() const { return static_cast<std::uint32_t>(first_poses_.size()); }

  // Back to the map as drawn, with the UAV at one of its starts. REQUIRES: start < starts().
  void reset(std::uint32_t start);

  // What the UAV observes now, below kCodes.
  std::uint32_t code() const { return (codes_[pose_ / kHeadings] >> (kCodeBits * (pose_ % kHeadings))) & kCodeMask; }

  // Random: below(n), uniform in [0, n). REQUIRES: action < kActions.
  template <typename Random>
  Outcome step(std::uint32_t action, Random& random) {
    const std::uint32_t next = after_[std::size_t{pose_} * kActionWidth + action];
    const bool collided = next == pose_;
    pose_ = next;
    double reward = collided ? kCollisionReward : kReward[action];
    const std::uint32_t cell = next / kHeadings;
    if (trash_[cell] != 0) {
      collect(cell, static_cast<std::size_t>(random.below(empty_.size())));
      reward = kTrashReward;
    }
    return {reward, collided, false};
  }

  // Where the UAV is: a cell of the map.
  std::size_t cell() const { return cells_[pose_ / kHeadings]; }
  Heading heading() const { return static_cast<Heading>(pose_ % kHeadings); }

  // The room as it is now: its only start is where the UAV is.
  RoomMap map() const;

 private:
  static constexpr std::size_t kActionWidth = 4;  // kActions, padded

  static constexpr unsigned kCodeBits = 16;
  static constexpr std::uint32_t kCodeMask = 0xFFFF;
  static constexpr std::size_t kViewers = 12;  // cells from which a cell can be seen

  void collect(std::uint32_t cell, std::size_t slot);

  // Cells here are floor cells, numbered in reading order; pose = cell * kHeadings + heading.
  std::size_t width_ = 0;
  std::size_t height_ = 0;
  std::vector<std::uint32_t> cells_;  // [floor cells] index in the map
  std::vector<std::uint32_t> after_;  // [poses x kActionWidth] the pose after an action; itself at a collision
  std::vector<std::uint32_t>
      viewers_;  // [floor cells x kViewers] the cell that sees it from there, or the one past the last
  std::vector<std::uint32_t> first_poses_;  // [starts]
  std::vector<std::uint64_t> first_codes_;
  std::vector<std::uint8_t> first_trash_;
  std::vector<std::uint32_t> first_empty_;

  std::optional<std::size_t> charger_;  // as drawn: only map() says it

  std::uint32_t pose_ = 0;
  std::vector<std::uint64_t>
      codes_;  // [floor cells + 1] what is seen from there now, for each heading; the last is scratch
  std::vector<std::uint8_t> trash_;   // [floor cells] 1 where a piece lies
  std::vector<std::uint32_t> empty_;  // floor cells without trash, in no particular order
};

}  // namespace coppice
