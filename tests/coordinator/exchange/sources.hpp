// Files for importers to read, and small models whose answers are known.
#pragma once

#include <array>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include "tests/temporary_folder.hpp"

namespace coppice::testing {

class SourceFiles {
 public:
  std::string write(const std::string& name, std::string_view content) {
    const std::string path = folder_ / name;
    std::ofstream(path, std::ios::binary).write(content.data(), static_cast<std::streamsize>(content.size()));
    return path;
  }

 private:
  TemporaryFolder folder_;
};

// Slippery lakes as Gymnasium draws them (S start, F frozen, H hole, G goal): a step goes where it is meant, or to
// either side, a third each; the edge holds. Reward 1 on arriving at the goal.
inline const std::vector<std::string> kLake4{"SFFF", "FHFH", "FFFH", "HFFG"};
inline const std::vector<std::string> kLake8{"SFFFFFFF", "FFFFFFFF", "FFFHFFFF", "FFFFFHFF",
                                             "FFFHFFFF", "FHHFFFHF", "FHFFHFHF", "FFFHFFFG"};

struct LakeStep {
  std::size_t to = 0;
  double reward = 0.0;
};
// Actions: left, down, right, up.
inline std::array<LakeStep, 3> lake_steps(const std::vector<std::string>& map, std::size_t from, std::size_t action) {
  const auto side = static_cast<int>(map.size());
  std::array<LakeStep, 3> steps;
  for (std::size_t slip = 0; slip < 3; ++slip) {
    const std::size_t direction = (action + 3 + slip) % 4;
    const int row = static_cast<int>(from) / side + (direction == 1 ? 1 : direction == 3 ? -1 : 0);
    const int column = static_cast<int>(from) % side + (direction == 2 ? 1 : direction == 0 ? -1 : 0);
    const bool inside = row >= 0 && row < side && column >= 0 && column < side;
    const std::size_t to = inside ? static_cast<std::size_t>(row * side + column) : from;
    steps[slip] = {to, map[to / map.size()][to % map.size()] == 'G' ? 1.0 : 0.0};
  }
  return steps;
}
inline char lake_cell(const std::vector<std::string>& map, std::size_t state) {
  return map[state / map.size()][state % map.size()];
}

// The lake as Storm writes it: rewards of choices are means; ends stay where they are.
std::string lake_drn(const std::vector<std::string>& map);
// The same as Gymnasium's tables.
std::string lake_tables(const std::vector<std::string>& map);

}  // namespace coppice::testing
