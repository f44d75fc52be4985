// A chain's rows made ready for sampling: the alias bins (alias_bins.hpp) of every row, packed so that a step of a
// roll-out reads 8 bytes of its row and 8 bytes of one bin.
//
// Two kinds of row exist without counts: a pair that was never tried leads to a state drawn uniformly from all
// (thesis VI-E.3), and "no action" stays where it is. Both are ordinary rows here, so a walk has no branch. Where
// Chain::taken() says that another action takes place, a row is that action's.
// Immutable; safe to share between threads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/chain/alias_bins.hpp"
#include "common/chain/chain.hpp"

namespace coppice {

// A row in one word: its number of bins in the low half, above it where they begin. The top bit is the reader's.
using PackedRow = std::uint64_t;
inline constexpr PackedRow kRowFlag = std::uint64_t{1} << 63U;
inline std::uint32_t bins_of(PackedRow row) { return static_cast<std::uint32_t>(row); }
inline std::uint32_t begin_of(PackedRow row) { return static_cast<std::uint32_t>((row & ~kRowFlag) >> 32U); }

// A bin in one word: cutoff_of() in the upper half, then the successor and the alias, 16 bits each.
using PackedBin = std::uint64_t;

class AliasRows {
 public:
  static constexpr std::size_t kStatesLimit = std::size_t{1} << 16U;
  static constexpr std::uint64_t kBinsLimit = std::uint64_t{1} << 31U;
  static bool fits(const Chain& chain);

  // REQUIRES: fits(chain).
  explicit AliasRows(const Chain& chain);

  // Rows are [states x (actions + 1)]: the last of a state is "no action".
  std::size_t stride() const { return stride_; }
  const std::vector<PackedRow>& rows() const { return rows_; }
  const std::vector<PackedBin>& bins() const { return bins_; }
  PackedRow row(std::size_t state, std::size_t action) const { return rows_[state * stride_ + action]; }
  // The largest number of bins of a row: a bound for is_decided() that suits all.
  std::uint32_t reach() const { return reach_; }

  // The successor that 32 random bits select; draw_more as in unit_of().
  template <typename DrawMore>
  std::uint32_t sample(PackedRow row, std::uint32_t x, const DrawMore& draw_more) const {
    const AliasPlace place = place_of(x, bins_of(row));
    const PackedBin bin = bins_[begin_of(row) + place.bin];
    const auto cutoff = static_cast<std::uint32_t>(bin >> 32U);
    if (!is_decided(place.within, cutoff, reach_)) [[unlikely]] {
      return sample_carefully(row, x, draw_more);
    }
    return successor_of(bin, place.within < cutoff);
  }

  // The same without the short cut.
  template <typename DrawMore>
  std::uint32_t sample_carefully(PackedRow row, std::uint32_t x, const DrawMore& draw_more) const {
    const std::uint32_t begin = begin_of(row);
    const std::uint32_t units = units_[begin];
    const std::uint64_t unit = unit_of(x, bins_of(row), units, draw_more);
    const std::size_t at = begin + unit / units;
    return successor_of(bins_[at], unit % units < thresholds_[at]);
  }

 private:
  static std::uint32_t successor_of(PackedBin bin, bool own) {
    return static_cast<std::uint32_t>(own ? bin >> 16U : bin) & 0xFFFFU;
  }
  void append(const AliasBin& bin, std::uint32_t units);

  std::size_t stride_ = 0;
  std::uint32_t reach_ = 1;
  std::vector<PackedRow> rows_;
  std::vector<PackedBin> bins_;
  // Exact numbers behind the cutoffs, for the few steps that need them. [bins]
  std::vector<std::uint32_t> thresholds_;
  std::vector<std::uint32_t> units_;  // of the bin's row
};

}  // namespace coppice
