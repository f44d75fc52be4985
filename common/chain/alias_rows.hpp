// Sampling a chain in constant time and exact integer arithmetic: Walker's alias method (1977, Vose's
// construction 1991) with integer thresholds. A row of k successors and N tries has k bins of N units; bin i
// gives its own successor for the first `threshold` units and its alias for the rest, and over all bins successor
// j owns exactly n_j k of the N k units. From 64 random bits x, floor(x k N / 2^64) names bin and unit at once
// (Lemire's multiply-shift); the few x for which that would not be uniform are redrawn. No division, no floating
// point: the same bits give the same successor on every CPU.
//
// Two kinds of row exist without counts: a pair that was never tried leads to a state drawn uniformly from all
// (thesis VI-E.3), and "no action" stays where it is. Both are ordinary rows here, so a walk has no branch.
// Immutable; safe to share between threads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/chain/random.hpp"

namespace coppice {

struct AliasEntry {
  std::uint32_t successor = 0;
  std::uint32_t alias = 0;
  std::uint32_t threshold = 0;  // units of the bin that are the successor's, 0..N
};

struct AliasRow {
  std::uint32_t begin = 0;  // of its entries
  std::uint32_t bins = 1;   // k
  std::uint32_t units = 1;  // N
};

class AliasRows {
 public:
  // Errors: more than 2^32 entries in all (transitions + 2 x states).
  static Result<AliasRows> make(const Chain& chain);

  // Rows are [states x (actions + 1)]: the last of a state is "no action".
  std::size_t stride() const { return stride_; }
  const AliasRow& row(std::size_t state, std::size_t action) const { return rows_[state * stride_ + action]; }

  // The successor that 64 random bits select. `redraw(attempt)` gives further bits (attempt = 1, 2, ...) when
  // x falls into the part that would make the choice uneven (fewer than one in 2^64 / (k N)).
  template <typename Redraw>
  std::uint32_t sample(std::size_t state, std::size_t action, std::uint64_t x, const Redraw& redraw) const {
    const AliasRow row = rows_[state * stride_ + action];
    const Uint128 by_bin = static_cast<Uint128>(x) * row.bins;
    const Uint128 by_unit = static_cast<Uint128>(static_cast<std::uint64_t>(by_bin)) * row.units;
    // The low half of x k N is below k N < 2^63 in the redrawn part only; one comparison with a bound of all rows
    // keeps the product k N off the common path.
    if (static_cast<std::uint64_t>(by_unit) < largest_product_) [[unlikely]] {
      return sample_carefully(row, x, redraw);
    }
    return pick(row, static_cast<std::uint64_t>(by_bin >> 64U), static_cast<std::uint64_t>(by_unit >> 64U));
  }

 private:
  AliasRows() = default;

  std::uint32_t pick(const AliasRow& row, std::uint64_t bin, std::uint64_t unit) const {
    const AliasEntry& entry = entries_[row.begin + bin];
    return unit < entry.threshold ? entry.successor : entry.alias;
  }

  template <typename Redraw>
  std::uint32_t sample_carefully(const AliasRow& row, std::uint64_t x, const Redraw& redraw) const {
    const std::uint64_t product = std::uint64_t{row.bins} * row.units;
    for (std::uint32_t attempt = 1; !accept(x, product); ++attempt) {
      x = redraw(attempt);
    }
    const std::uint64_t unit = scale(x, product);
    return pick(row, unit / row.units, unit % row.units);
  }

  std::size_t stride_ = 0;
  std::uint64_t largest_product_ = 0;
  std::vector<AliasRow> rows_;
  std::vector<AliasEntry> entries_;
};

}  // namespace coppice
