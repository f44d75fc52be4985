// Order by several costs at once (Deb, Pratap, Agarwal, Meyarivan, "A fast and elitist multiobjective genetic
// algorithm: NSGA-II", IEEE Transactions on Evolutionary Computation 6(2), 2002). All costs are to be small; a point
// dominates another when none of its costs is larger and one is smaller. Pure functions; the same numbers give the same
// order.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace coppice {

// Points by their costs: [points x costs], row-major. REQUIRES: no cost is NaN; values.size() a multiple of costs >= 1.
struct Costs {
  std::span<const double> values;
  std::size_t costs = 1;

  std::size_t points() const { return values.size() / costs; }
  std::span<const double> of(std::size_t point) const { return values.subspan(point * costs, costs); }
};

bool dominates(std::span<const double> a, std::span<const double> b);

// The rank of every point: 0 for those that nothing dominates, 1 for those that only points of rank 0 dominate, and so
// on. [points] NSGA-II's ranks, by sets of bits: with five costs nearly all points are of rank 0, where every
// comparison of two would be in vain, and 64 at once cost no more. Many points (8192): by efficient non-dominated sort
// (Zhang, Tian, Cheng, Jin, "An efficient approach to nondominated sorting for evolutionary multiobjective
// optimization", IEEE TEVC 19(2), 2015), whose memory is linear.
std::vector<std::uint32_t> ranks_of(const Costs& costs);

// How far a point's neighbours of its rank are apart, summed over the costs, each divided by its range in the rank;
// infinite at the ends of a cost. [points] NSGA-II, III-B.
std::vector<double> crowding_of(const Costs& costs, std::span<const std::uint32_t> ranks);

// Both, for less than one after the other.
struct Standing {
  std::vector<std::uint32_t> ranks;  // [points]
  std::vector<double> crowding;      // [points]
};
Standing standing_of(const Costs& costs);

// The `count` best points by rank, then by larger crowding distance, then by lower index.
struct Survivors {
  std::vector<std::size_t> points;  // [count], ascending
  Standing standing;                // of those points among themselves. [count]
};
// REQUIRES (both): count <= points.
Survivors survivors_of(const Costs& costs, std::size_t count);
// The same, for less, where no point dominates another.
Survivors survivors_of_front(const Costs& costs, std::size_t count);

}  // namespace coppice
