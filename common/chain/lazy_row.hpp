// Sampling a row straight from a chain, for chains too large to keep alias bins of every row: the row's bins are made
// anew each time. Gives what AliasRows::sample() gives for the same bits.
#pragma once

#include <cstdint>
#include <vector>

#include "common/chain/alias_bins.hpp"
#include "common/chain/chain.hpp"

namespace coppice {

class LazyRow {
 public:
  // `chosen`: an index, or the number of actions for none; what takes place is Chain::taken(). draw_more as in
  // unit_of(). One thread.
  template <typename DrawMore>
  std::uint32_t sample(const Chain& chain, std::uint32_t state, std::size_t chosen, std::uint32_t x,
                       const DrawMore& draw_more) {
    const std::size_t action = chain.taken(state, chosen);
    if (action == chain.actions()) {
      return state;
    }
    const std::size_t row = std::size_t{state} * chain.actions() + action;
    const auto successors = chain.successors(row);
    const auto count = static_cast<std::uint32_t>(successors.empty() ? chain.states() : successors.size());
    const AliasPlace place = place_of(x, count);
    if (successors.size() <= 1) {  // never tried: any state, evenly; or the only successor
      const bool decided = is_decided(place.within, UINT32_MAX, count);
      const std::uint64_t unit = decided ? place.bin : unit_of(x, count, 1, draw_more);
      return successors.empty() ? static_cast<std::uint32_t>(unit) : successors[0];
    }
    const auto units = static_cast<std::uint32_t>(chain.tries(row));
    bins_.resize(count);
    fill_bins(successors, chain.counts(row), units, bins_);
    const AliasBin& bin = bins_[place.bin];
    const std::uint32_t cutoff = cutoff_of(bin.threshold, units);
    if (is_decided(place.within, cutoff, count)) {
      return place.within < cutoff ? bin.successor : bin.alias;
    }
    const std::uint64_t unit = unit_of(x, count, units, draw_more);
    const AliasBin& exact = bins_[unit / units];
    return unit % units < exact.threshold ? exact.successor : exact.alias;
  }

 private:
  std::vector<AliasBin> bins_;
};

}  // namespace coppice
