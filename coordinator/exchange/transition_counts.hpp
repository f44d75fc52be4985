// Counts transitions of any number of rows in little more memory than a chain needs for them: keys are gathered, sorted
// in batches and merged into what is known. A batch costs a sort; chain_builder.hpp, which hashes, is quicker where
// there are few distinct transitions and takes up to five times the memory where there are many. One thread.
#pragma once

#include <cstdint>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/error.hpp"

namespace coppice {

class TransitionCounts {
 public:
  explicit TransitionCounts(std::size_t actions) : actions_(actions) {}

  void count(std::uint32_t state, std::uint32_t action, std::uint32_t next) {
    batch_.push_back((std::uint64_t{state} * actions_ + action) << 32U | next);
    if (batch_.size() >= kBatch && batch_.size() >= keys_.size() / 4) {
      merge();
    }
  }

  // Writes row_begin, successor and count of `parts` for `states` states, and is empty then. Errors: a count that
  // reached 2^32, more than kMaxTransitions.
  Result<void> move_to(std::size_t states, ChainParts& parts);

 private:
  static constexpr std::size_t kBatch = std::size_t{1} << 17U;
  void merge();

  std::size_t actions_;
  std::vector<std::uint64_t> batch_;   // row and successor, as they came
  std::vector<std::uint64_t> keys_;    // ascending
  std::vector<std::uint32_t> counts_;  // of keys_
  bool overflowed_ = false;
};

}  // namespace coppice
