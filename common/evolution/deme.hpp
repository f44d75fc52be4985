// A deme: a population of its own inside a run, between two of its generations. Plain values: with the configuration,
// all that its next generation depends on.
#pragma once

#include <cstdint>
#include <vector>

#include "common/fitness/job.hpp"
#include "common/tree/tree.hpp"

namespace coppice {

struct Individual {
  Tree tree{ActionId{0}};
  Tally tally;
  bool operator==(const Individual&) const = default;
};

struct Deme {
  std::uint32_t generations = 0;       // evaluated so far; the population is that of the last one
  std::vector<Individual> population;  // by slot
  std::vector<Individual> archive;     // search front: the trees kept on the front, in order of entry
  bool operator==(const Deme&) const = default;
};

}  // namespace coppice
