#include "common/chain/alias_rows.hpp"

#include <algorithm>
#include <fmt/format.h>

namespace coppice {
namespace {

// Appends the bins of one row. `scaled[i]` is n_i k; a bin holds N units.
void append_bins(std::span<const std::uint32_t> successors, std::span<const std::uint32_t> counts, std::uint64_t units,
                 std::vector<AliasEntry>& entries) {
  const std::size_t bins = successors.size();
  const std::size_t begin = entries.size();
  std::vector<std::uint64_t> scaled(bins);
  std::vector<std::uint32_t> small;
  std::vector<std::uint32_t> large;
  for (std::size_t i = 0; i < bins; ++i) {
    scaled[i] = std::uint64_t{counts[i]} * bins;
    (scaled[i] < units ? small : large).push_back(static_cast<std::uint32_t>(i));
    entries.push_back({successors[i], successors[i], static_cast<std::uint32_t>(units)});
  }
  while (!small.empty()) {
    const std::uint32_t lacking = small.back();
    small.pop_back();
    const std::uint32_t giving = large.back();  // exists: the bins' mean is exactly one full bin
    entries[begin + lacking].alias = successors[giving];
    entries[begin + lacking].threshold = static_cast<std::uint32_t>(scaled[lacking]);
    scaled[giving] -= units - scaled[lacking];
    if (scaled[giving] < units) {
      large.pop_back();
      small.push_back(giving);
    }
  }
}

}  // namespace

Result<AliasRows> AliasRows::make(const Chain& chain) {
  const std::size_t states = chain.states();
  const std::uint64_t entries = std::uint64_t{chain.transitions()} + 2 * std::uint64_t{states};
  if (entries >> 32U != 0) {
    return bad_input(fmt::format("chain needs {} sampling entries: expected below 2^32", entries));
  }
  AliasRows result;
  result.stride_ = chain.actions() + 1;
  result.rows_.resize(states * result.stride_);
  result.entries_.reserve(entries);
  // Shared by all untried pairs: every state, one unit each.
  const AliasRow uniform{0, static_cast<std::uint32_t>(states), 1};
  for (std::uint32_t state = 0; state < states; ++state) {
    result.entries_.push_back({state, state, 1});
  }
  result.largest_product_ = states;
  for (std::uint32_t state = 0; state < states; ++state) {
    for (std::size_t action = 0; action < chain.actions(); ++action) {
      const std::size_t row = state * chain.actions() + action;
      AliasRow& alias_row = result.rows_[state * result.stride_ + action];
      if (chain.tries(row) == 0) {
        alias_row = uniform;
        continue;
      }
      const auto successors = chain.successors(row);
      alias_row = {static_cast<std::uint32_t>(result.entries_.size()), static_cast<std::uint32_t>(successors.size()),
                   static_cast<std::uint32_t>(chain.tries(row))};
      append_bins(successors, chain.counts(row), chain.tries(row), result.entries_);
      result.largest_product_ = std::max(result.largest_product_, std::uint64_t{alias_row.bins} * alias_row.units);
    }
    result.rows_[state * result.stride_ + chain.actions()] = {static_cast<std::uint32_t>(result.entries_.size()), 1, 1};
    result.entries_.push_back({state, state, 1});
  }
  return result;
}

}  // namespace coppice
