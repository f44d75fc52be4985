// How fitness and size went in each deme, for the page: kept with a run's outcome, sampled so that it stays small.
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <vector>

#include "common/evolution/champion.hpp"

namespace coppice {

class DemeCurves {
 public:
  static constexpr std::size_t kMostPoints = 300;  // of each deme

  // Generations that follow those before, or take the place of some of them: the same of every deme, one or more.
  // [demes][generations]
  void add(std::span<const std::vector<GenerationRecord>> of_demes);

  bool empty() const { return generation_.empty(); }
  // {"generation": [points], "demes": [{"best_fitness", "mean_fitness", "best_nodes", "mean_nodes": [points]}]}, the
  // last generation always among the points.
  nlohmann::ordered_json json() const;

 private:
  struct Point {
    double best_fitness = 0.0;
    double mean_fitness = 0.0;
    double best_nodes = 0.0;
    double mean_nodes = 0.0;
  };
  std::vector<std::uint32_t> generation_;
  std::vector<std::vector<Point>> demes_;  // [demes][generations]
};

}  // namespace coppice
