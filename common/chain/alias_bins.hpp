// Walker's alias method (1977, Vose's construction 1991) in exact integers. A row of k successors and N tries has k
// bins of N units; bin i gives its own successor for its first `threshold` units and its alias for the rest, and over
// all bins successor j owns exactly n_j k of the k N units.
//
// A roll-out's step brings 32 random bits x. With v drawn uniformly from [0, k N), the number x k N + v is uniform over
// [0, 2^32 k N), so u = (x k N + v) >> 32 is exactly uniform over the k N units: bin u / N, unit u % N. For nearly all
// x every v gives the same successor; those need no v, which is what fast_choice() finds out with one multiplication.
// The same bits give the same successor on every CPU.
#pragma once

#include <cstdint>
#include <span>

#include "common/chain/random.hpp"

namespace coppice {

struct AliasBin {
  std::uint32_t successor = 0;
  std::uint32_t alias = 0;
  std::uint32_t threshold = 0;  // units of the bin that are the successor's, 0..N
};

// Fills one bin for each successor. REQUIRES: all three of one size >= 1, counts >= 1, units = their sum < 2^32.
void fill_bins(std::span<const std::uint32_t> successors, std::span<const std::uint32_t> counts, std::uint32_t units,
               std::span<AliasBin> bins);

// Where 32 random bits fall in a row of k bins: in `bin`, at a place within [within, within + k) of 2^32.
struct AliasPlace {
  std::uint32_t bin;
  std::uint32_t within;
};
inline AliasPlace place_of(std::uint32_t x, std::uint32_t bins) {
  const std::uint64_t product = std::uint64_t{x} * bins;
  return {static_cast<std::uint32_t>(product >> 32U), static_cast<std::uint32_t>(product)};
}

// A bin's threshold as a part of 2^32, rounded down.
inline std::uint32_t cutoff_of(std::uint32_t threshold, std::uint32_t units) {
  return threshold >= units ? UINT32_MAX : static_cast<std::uint32_t>((std::uint64_t{threshold} << 32U) / units);
}

// Whether x alone decides: the place straddles neither the end of its bin nor the bin's cutoff. `reach` is k, or any
// larger number.
inline bool is_decided(std::uint32_t within, std::uint32_t cutoff, std::uint32_t reach) {
  return within <= 0U - reach && cutoff - within >= reach;
}

// The unit u that x and further bits select. draw_more(attempt), attempt = 0, 1, ..., gives 64 bits; all but the first
// are needed with a probability below k N / 2^64 only.
template <typename DrawMore>
std::uint64_t unit_of(std::uint32_t x, std::uint32_t bins, std::uint32_t units, const DrawMore& draw_more) {
  const std::uint64_t all = std::uint64_t{bins} * units;
  std::uint32_t attempt = 0;
  std::uint64_t bits = draw_more(attempt);
  while (!accept(bits, all)) {
    bits = draw_more(++attempt);
  }
  return static_cast<std::uint64_t>((static_cast<Uint128>(x) * all + scale(bits, all)) >> 32U);
}

}  // namespace coppice
