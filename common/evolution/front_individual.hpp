// What a front search knows of a tree, and groups of such trees: those to choose parents from, and those kept.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/chain/random.hpp"
#include "common/evolution/dominance.hpp"
#include "common/fitness/job.hpp"
#include "common/fitness/meaning.hpp"
#include "common/tree/tree.hpp"

namespace coppice {

struct FrontIndividual {
  Tree tree{ActionId{0}};
  Meaning meaning;
  Tally tally;
  double fitness = 0.0;       // scalar
  std::vector<double> costs;  // [front.objectives], all to be small
};

// [individuals x costs]
std::vector<double> costs_of(const std::vector<FrontIndividual>& individuals);

// Keeps the `count` best by rank and crowding (dominance.hpp), in the order in which they stood; gives how those stand
// among themselves. REQUIRES: count <= individuals.size(), all with `costs` costs.
Standing keep_best(std::vector<FrontIndividual>& individuals, std::size_t costs, std::size_t count);

// Weights that sum to 1, uniform among all such (the gaps between sorted uniform numbers). One for each of `weights`;
// at most kMeasures.
void draw_weights(Stream& stream, std::span<double> weights);

// Individuals to choose parents from, with what choosing needs. Refers to them and to their standing.
class ParentPool {
 public:
  // `standing`, null: none dominates another, and nobody chooses by crowding.
  // REQUIRES: individuals not empty, all with `costs` costs.
  ParentPool(const std::vector<FrontIndividual>& individuals, std::size_t costs, const Standing* standing);

  // NSGA-II's binary tournament: the lower rank, then the less crowded, then the first drawn. REQUIRES: a standing.
  const FrontIndividual& by_crowding(Stream& stream) const;
  // The smallest weighted sum of costs, each by its range on the front, among `size` drawn.
  const FrontIndividual& by_weights(Stream& stream, std::span<const double> weights, std::size_t size) const;

  // The same weights for costs in their own units: each by its range on the front; where it has none, as it is. [costs]
  std::vector<double> by_range(std::span<const double> weights) const;

 private:
  double weighted(std::size_t i, std::span<const double> weights) const;

  const std::vector<FrontIndividual>& individuals_;
  const Standing* const standing_;
  const std::vector<double> values_;  // [individuals x costs]
  std::vector<double> low_;           // [costs], on the front
  std::vector<double> high_;          // [costs]
};

// Every tree so far that no other dominates.
class FrontArchive {
 public:
  // REQUIRES: of at most max_nodes nodes each, evaluated, and none dominates another.
  void assign(std::vector<FrontIndividual> members);
  // Takes it in unless a member is as good in everything; what it dominates goes. Nothing that is larger than
  // `max_nodes` or was not evaluated.
  void offer(const FrontIndividual& candidate, std::size_t max_nodes);

  // Keeps the `count` least crowded, if there are more. REQUIRES: all with `costs` costs.
  void thin(std::size_t costs, std::size_t count);

  const std::vector<FrontIndividual>& members() const { return members_; }

 private:
  std::vector<FrontIndividual> members_;
  std::vector<double> values_;  // [members x costs], theirs, side by side
  std::size_t latest_ = 0;      // who kept the last candidate out
};

}  // namespace coppice
