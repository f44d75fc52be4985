// Where to cut the readings of a continuous feature into bins. An edge is the shortest decimal near the cut, so that a
// condition reads well ("pole_angle<=0.04"): where there are thousands of readings, up to one in five hundred may
// change sides for it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/error.hpp"

namespace coppice {

// One reading with what the policy did there, and how much it counts.
struct ClassedReading {
  double reading = 0.0;
  std::uint8_t action = 0;
  double weight = 1.0;  // > 0
};

// The shortest decimal r with low <= r < high, near the middle. REQUIRES: low < high, both finite.
double short_number_between(double low, double high);

// At most bins - 1 edges with an equal weight of readings between them, as far as equal readings allow.
// REQUIRES (both): bins >= 2; finite readings. The order of readings does not matter.
std::vector<double> quantile_edges(std::vector<ClassedReading> readings, std::size_t bins);

// Where the policy changes: the cut that leaves the least entropy of the action, again in both parts, as long as it is
// worth its description (the minimum description length principle of Fayyad and Irani, "Multi-interval discretization
// of continuous-valued attributes for classification learning", IJCAI 1993, section 3). Of the cuts found the bins - 1
// that gain most are kept. We differ: with `at_least_one` the best cut is kept even where it is not worth its
// description, so that the feature can be tested at all.
std::vector<double> entropy_edges(std::vector<ClassedReading> readings, std::size_t bins, bool at_least_one);

// Edges as somebody gave them: sorted, repeats left out.
Result<std::vector<double>> given_edges(std::span<const double> edges);

}  // namespace coppice
