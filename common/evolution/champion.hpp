// Who led which generation, and a generation's row of the statistics. Plain values.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/tree/tree.hpp"

namespace coppice {

// The best individual of one generation, as it was measured there.
struct Champion {
  Tree tree{ActionId{0}};
  std::uint32_t generation = 0;
  double fitness = 0.0;    // scalar
  double agreement = 0.0;  // matches / steps along the walks
  bool operator==(const Champion&) const = default;
};

// One row of a run's statistics.
struct GenerationRecord {
  std::uint32_t generation = 0;  // from 0
  Champion best;                 // highest fitness; ties: fewer nodes, then the lower slot
  double mean_fitness = 0.0;
  double mean_agreement = 0.0;
  double mean_nodes = 0.0;
  std::uint32_t distinct_trees = 0;
  std::uint32_t meanings = 0;     // different action tables, where they were asked for; else 0
  std::uint64_t evaluations = 0;  // individuals evaluated in this generation
  double seconds = 0.0;           // wall time of this generation; the only field that a repetition does not repeat

  std::size_t best_nodes() const { return best.tree.size(); }
  bool operator==(const GenerationRecord&) const = default;
};

// The champions of all generations so far, distinct trees in order of first entry; a tree that led several
// generations keeps its first generation and its highest fitness.
using HallOfFame = std::vector<Champion>;
void enter(const Champion& champion, HallOfFame& hall);
// The highest fitness; ties: fewer nodes, then earlier. REQUIRES: hall is not empty.
const Champion& best_on_record(const HallOfFame& hall);

}  // namespace coppice
