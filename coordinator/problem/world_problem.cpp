#include "coordinator/problem/world_problem.hpp"

#include <algorithm>
#include <array>

namespace coppice {
namespace {

struct Sensor {
  std::string_view name;
  std::string_view label;
};

// coordinator/learning/uav_room.hpp, "Sensors".
constexpr std::array<Sensor, 8> kSensors{{{"s0", "two left"},
                                          {"s1", "left"},
                                          {"s2", "ahead left"},
                                          {"s3", "ahead"},
                                          {"s4", "ahead right"},
                                          {"s5", "right"},
                                          {"s6", "two right"},
                                          {"s7", "two ahead"}}};

void label_room(const Vocabulary& vocabulary, Problem& problem) {
  for (std::size_t f = 0; f < vocabulary.features.size(); ++f) {
    const Feature& feature = vocabulary.features[f];
    const auto* sensor = std::find_if(kSensors.begin(), kSensors.end(),
                                      [&](const Sensor& candidate) { return candidate.name == feature.name; });
    if (sensor != kSensors.end()) {
      problem.features[f].label = sensor->label;
      problem.features[f].values = {{0, "wall"}, {1, "free"}, {3, "trash"}};
    }
  }
}

void label_battery(const Vocabulary& vocabulary, Problem& problem) {
  for (std::size_t f = 0; f < vocabulary.features.size(); ++f) {
    if (vocabulary.features[f].name == "battery") {
      problem.features[f].label = "battery";
      problem.features[f].values = {
          {0, "nearly empty"}, {1, "a quarter"}, {2, "half"}, {3, "three quarters"}, {4, "nearly full"}};
    } else if (vocabulary.features[f].name == "charger") {
      problem.features[f].label = "charger";
      problem.features[f].values = {{0, "here"}, {1, "ahead"}, {2, "right"}, {3, "behind"}, {4, "left"}};
    }
  }
}

void label_grid(const Vocabulary& vocabulary, Problem& problem) {
  for (std::size_t f = 0; f < vocabulary.features.size(); ++f) {
    if (vocabulary.features[f].name == "x") {
      problem.features[f].label = "column";
    } else if (vocabulary.features[f].name == "y") {
      problem.features[f].label = "row";
    }
  }
}

}  // namespace

Problem problem_of_world(std::string_view kind, const Vocabulary& vocabulary) {
  Problem problem = unlabelled(vocabulary);
  if (kind == "uav") {
    label_room(vocabulary, problem);
  } else if (kind == "battery") {
    label_room(vocabulary, problem);
    label_battery(vocabulary, problem);
  } else if (kind == "windy") {
    label_grid(vocabulary, problem);
  }
  return problem;
}

}  // namespace coppice
