// Probabilities turned into counts, which is what a chain samples from.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace coppice {

// The sum of a row's counts, at most.
inline constexpr std::uint32_t kMostCounts = std::uint32_t{1} << 31U;

// Counts that stand to each other as the probabilities do, by the method of the largest remainder (Hamilton): each gets
// the whole part of its share of N, and what is left goes to the largest fractions, ties to the lowest index. N is the
// largest multiple of the row's common denominator up to kMostCounts, where the probabilities are (to within 1e-10, the
// digits that tools print) fractions with one up to 10,000; else kMostCounts. So 0.3333333333 and 0.6666666667 become
// exact thirds. A probability far below 1 / N may get none. Sums are large on purpose: they say that a model knows its
// probabilities, where small counts would be taken for few observations.
// REQUIRES: not empty, probabilities > 0 that sum to 1.
std::vector<std::uint32_t> counts_of(std::span<const double> probabilities);

}  // namespace coppice
