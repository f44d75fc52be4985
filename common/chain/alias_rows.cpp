#include "common/chain/alias_rows.hpp"

#include "common/check.hpp"

namespace coppice {
namespace {

PackedRow packed_row(std::size_t begin, std::size_t bins) { return (PackedRow{begin} << 32U) | bins; }

std::uint64_t bins_needed(const Chain& chain) {
  return std::uint64_t{chain.transitions()} + 2 * std::uint64_t{chain.states()};
}

}  // namespace

bool AliasRows::fits(const Chain& chain) { return chain.states() <= kStatesLimit && bins_needed(chain) < kBinsLimit; }

AliasRows::AliasRows(const Chain& chain) : stride_(chain.actions() + 1) {
  COPPICE_CHECK(fits(chain));
  const auto states = static_cast<std::uint32_t>(chain.states());
  rows_.resize(states * stride_);
  bins_.reserve(bins_needed(chain));
  thresholds_.reserve(bins_needed(chain));
  units_.reserve(bins_needed(chain));
  // Shared by all untried pairs: every state, one unit each.
  const PackedRow uniform = packed_row(0, states);
  reach_ = states;  // no row has more bins
  for (std::uint32_t state = 0; state < states; ++state) {
    append({state, state, 1}, 1);
  }
  std::vector<AliasBin> bins;
  for (std::uint32_t state = 0; state < states; ++state) {
    for (std::size_t action = 0; action < chain.actions(); ++action) {
      const std::size_t row = state * chain.actions() + action;
      const auto successors = chain.successors(row);
      if (successors.empty()) {
        rows_[state * stride_ + action] = uniform;
        continue;
      }
      rows_[state * stride_ + action] = packed_row(bins_.size(), successors.size());
      const auto units = static_cast<std::uint32_t>(chain.tries(row));
      bins.resize(successors.size());
      fill_bins(successors, chain.counts(row), units, bins);
      for (const AliasBin& bin : bins) {
        append(bin, units);
      }
    }
    rows_[state * stride_ + chain.actions()] = packed_row(bins_.size(), 1);
    append({state, state, 1}, 1);
    for (std::size_t chosen = 0; chosen <= chain.actions(); ++chosen) {
      const std::size_t taken = chain.taken(state, chosen);
      if (taken != chosen) {
        rows_[state * stride_ + chosen] = rows_[state * stride_ + taken];
      }
    }
  }
}

void AliasRows::append(const AliasBin& bin, std::uint32_t units) {
  bins_.push_back((PackedBin{cutoff_of(bin.threshold, units)} << 32U) | (PackedBin{bin.successor} << 16U) | bin.alias);
  thresholds_.push_back(bin.threshold);
  units_.push_back(units);
}

}  // namespace coppice
