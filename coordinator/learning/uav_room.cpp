#include "coordinator/learning/uav_room.hpp"

#include <algorithm>

#include "common/check.hpp"

namespace coppice {
namespace {

constexpr std::uint32_t kNotFloor = 0xFFFFFFFF;
constexpr std::array<std::uint8_t, 3> kReading{0, 1, 3};

struct Vector {
  int x = 0;
  int y = 0;  // downwards, as lines are read
  bool operator==(const Vector&) const = default;
};
constexpr std::array<Vector, kHeadings> kForward{{{0, -1}, {1, 0}, {0, 1}, {-1, 0}}};

constexpr Vector sum(Vector a, Vector b) { return {a.x + b.x, a.y + b.y}; }

// Where a sensor looks, seen from the UAV.
constexpr Vector sensed(std::size_t sensor, std::size_t heading) {
  const Vector ahead = kForward[heading];
  const Vector right = kForward[(heading + 1) % kHeadings];
  const Vector left = kForward[(heading + 3) % kHeadings];
  switch (sensor) {
    case 0:
      return sum(left, left);
    case 1:
      return left;
    case 2:
      return sum(ahead, left);
    case 3:
      return ahead;
    case 4:
      return sum(ahead, right);
    case 5:
      return right;
    case 6:
      return sum(right, right);
    default:
      return sum(ahead, ahead);
  }
}

// The twelve cells that some heading sees. The last four lie two cells off, each behind the one four places before.
constexpr std::array<Vector, 12> kSeen{
    {{-1, -1}, {1, -1}, {-1, 1}, {1, 1}, {0, -1}, {1, 0}, {0, 1}, {-1, 0}, {0, -2}, {2, 0}, {0, 2}, {-2, 0}}};
constexpr std::size_t kFirstBehind = 8;

// For each of kSeen, what one more in its base-3 digit adds to the codes of the four headings.
constexpr std::array<std::uint64_t, 12> weights(unsigned code_bits) {
  std::array<std::uint64_t, 12> result{};
  for (std::size_t seen = 0; seen < kSeen.size(); ++seen) {
    for (std::size_t heading = 0; heading < kHeadings; ++heading) {
      std::uint64_t digit = std::uint64_t{1} << (code_bits * heading);
      for (std::size_t sensor = 0; sensor < UavRoom::kSensors; ++sensor, digit *= 3) {
        result[seen] += sensed(sensor, heading) == kSeen[seen] ? digit : 0;
      }
    }
  }
  return result;
}

std::size_t neighbour(const RoomMap& map, std::size_t cell, Vector offset) {
  return static_cast<std::size_t>(static_cast<std::int64_t>(cell) + offset.y * static_cast<std::int64_t>(map.width) +
                                  offset.x);
}

// Whether `seen` of kSeen shows something else than wall. The border is wall, so a cell is looked up only within the
// map: what lies behind a wall is not.
bool visible(const RoomMap& map, std::size_t cell, std::size_t seen) {
  if (seen >= kFirstBehind && map.cells[neighbour(map, cell, kSeen[seen - 4])] == Cell::wall) {
    return false;
  }
  return map.cells[neighbour(map, cell, kSeen[seen])] != Cell::wall;
}

}  // namespace

UavRoom::UavRoom(const RoomMap& map) : width_(map.width), height_(map.height), charger_(map.charger) {
  static_assert(kViewers == kSeen.size());
  constexpr std::array kWeight = weights(kCodeBits);
  std::vector<std::uint32_t> floor(map.cells.size(), kNotFloor);
  for (std::size_t cell = 0; cell < map.cells.size(); ++cell) {
    if (map.cells[cell] != Cell::wall) {
      floor[cell] = static_cast<std::uint32_t>(cells_.size());
      cells_.push_back(static_cast<std::uint32_t>(cell));
      const bool trash = map.cells[cell] == Cell::trash;
      first_trash_.push_back(trash ? 1 : 0);
      if (!trash) {
        first_empty_.push_back(floor[cell]);
      }
    }
  }
  const auto nobody = static_cast<std::uint32_t>(cells_.size());
  first_codes_.assign(cells_.size() + 1, 0);
  viewers_.assign(cells_.size() * kViewers, nobody);
  for (std::uint32_t viewer = 0; viewer < nobody; ++viewer) {
    for (std::size_t seen = 0; seen < kSeen.size(); ++seen) {
      if (visible(map, cells_[viewer], seen)) {
        const std::size_t cell = neighbour(map, cells_[viewer], kSeen[seen]);
        first_codes_[viewer] += kWeight[seen] * (map.cells[cell] == Cell::trash ? 2 : 1);
        viewers_[floor[cell] * kViewers + seen] = viewer;
      }
    }
    for (std::uint32_t heading = 0; heading < kHeadings; ++heading) {
      const std::uint32_t ahead = floor[neighbour(map, cells_[viewer], kForward[heading])];
      after_.push_back((ahead == kNotFloor ? viewer : ahead) * kHeadings + heading);
      after_.push_back(viewer * kHeadings + (heading + 3) % kHeadings);
      after_.push_back(viewer * kHeadings + (heading + 1) % kHeadings);
      after_.push_back(viewer * kHeadings + heading);
    }
  }
  COPPICE_CHECK(!map.starts.empty());
  for (const RoomStart& start : map.starts) {
    COPPICE_CHECK(floor[start.cell] != kNotFloor);
    first_poses_.push_back(floor[start.cell] * kHeadings + static_cast<std::uint32_t>(start.heading));
  }
  reset(0);
}

Vocabulary UavRoom::vocabulary() {
  Vocabulary vocabulary;
  for (const char* name : {"s0", "s1", "s2", "s3", "s4", "s5", "s6", "s7"}) {
    vocabulary.features.push_back({name, {kReading.begin(), kReading.end()}, true, false});
  }
  vocabulary.actions = {"move", "turn_left", "turn_right"};
  return vocabulary;
}

void UavRoom::features_of(std::uint32_t code, std::span<std::uint8_t> features) {
  COPPICE_CHECK(code < kCodes && features.size() == kSensors);
  for (std::uint8_t& feature : features) {
    feature = kReading[code % 3];
    code /= 3;
  }
}

std::uint32_t UavRoom::code_of(std::span<const std::uint8_t> features) {
  COPPICE_CHECK(features.size() == kSensors);
  std::uint32_t code = 0;
  for (std::size_t i = kSensors; i > 0; --i) {
    const auto digit = std::find(kReading.begin(), kReading.end(), features[i - 1]);
    COPPICE_CHECK(digit != kReading.end());
    code = 3 * code + static_cast<std::uint32_t>(digit - kReading.begin());
  }
  return code;
}

void UavRoom::reset(std::uint32_t start) {
  pose_ = first_poses_[start];
  codes_ = first_codes_;
  trash_ = first_trash_;
  empty_ = first_empty_;
}

// The cell collected from is not among the empty ones while the new piece's cell is drawn, which keeps the new piece
// from under the UAV.
void UavRoom::collect(std::uint32_t cell, std::size_t slot) {
  const std::uint32_t fresh = empty_[slot];
  empty_[slot] = cell;
  trash_[cell] = 0;
  trash_[fresh] = 1;
  constexpr std::array kWeight = weights(kCodeBits);
  const std::size_t left = cell * kViewers;
  const std::size_t found = fresh * kViewers;
  for (std::size_t seen = 0; seen < kViewers; ++seen) {
    codes_[viewers_[left + seen]] -= kWeight[seen];
    codes_[viewers_[found + seen]] += kWeight[seen];
  }
}

RoomMap UavRoom::map() const {
  RoomMap map{width_, height_, std::vector<Cell>(width_ * height_, Cell::wall), {{cell(), heading()}}, charger_};
  for (std::size_t floor = 0; floor < cells_.size(); ++floor) {
    map.cells[cells_[floor]] = trash_[floor] != 0 ? Cell::trash : Cell::free;
  }
  return map;
}

}  // namespace coppice
