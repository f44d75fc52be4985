// Who may have children: the order of a generation's individuals and tournaments between them (thesis III-D).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/chain/random.hpp"
#include "common/tree/tree.hpp"

namespace coppice {

// All slots, the best first: higher fitness, then fewer nodes, then the lower slot. A total order, so it is the same
// wherever the fitness is. REQUIRES: one fitness per tree, none of them NaN.
std::vector<std::size_t> ranking(std::span<const Tree> population, std::span<const double> fitness);

// Individuals in one tournament: the share of the population, rounded; at least 1, at most all.
std::size_t tournament_size(double share, std::size_t population);

// The fittest of `size` slots that are drawn uniformly, with replacement; ties: the one drawn first, whatever its size.
// Equal fitness is common (two trees that do the same have the same), and a tournament that preferred the smaller tree
// bred all spare material out of a population within 30 generations, and the discoveries with it.
// REQUIRES: fitness is not empty, none of it NaN; size >= 1.
std::size_t tournament(Stream& stream, std::span<const double> fitness, std::size_t size);

}  // namespace coppice
