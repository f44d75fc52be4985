#include "coordinator/exchange/transition_counts.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "common/check.hpp"

namespace coppice {

// From the back, in place: the known ones move up to make room for what is new.
void TransitionCounts::merge() {
  std::sort(batch_.begin(), batch_.end());
  std::size_t fresh = 0;
  for (std::size_t k = 0, b = 0; b < batch_.size();) {
    const std::uint64_t key = batch_[b];
    while (b < batch_.size() && batch_[b] == key) {
      ++b;
    }
    k = static_cast<std::size_t>(std::lower_bound(keys_.begin() + static_cast<std::ptrdiff_t>(k), keys_.end(), key) -
                                 keys_.begin());
    fresh += k == keys_.size() || keys_[k] != key ? 1 : 0;
  }
  std::size_t from = keys_.size();
  std::size_t to = from + fresh;
  if (to > keys_.capacity()) {  // by less than the doubling of a vector: most of the memory of an import is here
    keys_.reserve(to + to / 8);
    counts_.reserve(to + to / 8);
  }
  keys_.resize(to);
  counts_.resize(to);
  for (std::size_t b = batch_.size(); b > 0;) {
    const std::uint64_t key = batch_[b - 1];
    std::uint64_t count = 0;
    while (b > 0 && batch_[b - 1] == key) {
      --b;
      ++count;
    }
    while (from > 0 && keys_[from - 1] > key) {
      --from;
      --to;
      keys_[to] = keys_[from];
      counts_[to] = counts_[from];
    }
    if (from > 0 && keys_[from - 1] == key) {
      --from;
      count += counts_[from];
    }
    --to;
    overflowed_ = overflowed_ || count >> 32U != 0;
    keys_[to] = key;
    counts_[to] = static_cast<std::uint32_t>(count);
  }
  COPPICE_CHECK(from == to);
  batch_.clear();
}

Result<void> TransitionCounts::move_to(std::size_t states, ChainParts& parts) {
  merge();
  std::vector<std::uint64_t>().swap(batch_);
  if (overflowed_ || keys_.size() > kMaxTransitions) {
    return bad_input(
        fmt::format("{} transitions, or one of them 2^32 times or more: expected at most {}, and fewer times",
                    keys_.size(), kMaxTransitions));
  }
  const std::size_t rows = states * actions_;
  parts.row_begin.assign(rows + 1, 0);
  parts.successor.resize(keys_.size());
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    const std::uint64_t row = keys_[i] >> 32U;
    COPPICE_CHECK(row < rows);
    ++parts.row_begin[row + 1];
    parts.successor[i] = static_cast<std::uint32_t>(keys_[i]);
  }
  std::vector<std::uint64_t>().swap(keys_);
  for (std::size_t row = 0; row < rows; ++row) {
    parts.row_begin[row + 1] += parts.row_begin[row];
  }
  counts_.shrink_to_fit();
  parts.count = std::move(counts_);
  counts_.clear();
  return {};
}

}  // namespace coppice
