// Counts transitions while a policy is learned and turns the counts into a Chain. One builder belongs to one
// learning loop (not thread-safe); count() is on its critical path, at a few nanoseconds: successors of all rows share
// one open-addressing table, whose busiest entries stay in the cache.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/chain/chain.hpp"

namespace coppice {

class ChainBuilder {
 public:
  explicit ChainBuilder(std::size_t actions);

  // One observed transition: in `state`, `action` led to `next`.
  void count(std::uint32_t state, std::uint32_t action, std::uint32_t next) {
    const std::uint64_t row = std::uint64_t{state} * actions_ + action;
    const std::uint64_t key = (row << 32U | next) + 1;  // 0 marks a free slot
    std::size_t slot = static_cast<std::size_t>((key * 0x9E3779B97F4A7C15) >> shift_);
    while (slots_[slot].key != key) {
      if (slots_[slot].key == 0) {
        insert(key);
        return;
      }
      slot = (slot + 1) & (slots_.size() - 1);
    }
    ++slots_[slot].count;
  }

  std::size_t transitions() const { return used_; }

  // All that was counted, to be kept and added to a new builder: ascending by row, then by next.
  struct Counted {
    std::uint64_t row = 0;  // state * actions + action
    std::uint64_t next = 0;
    std::uint64_t count = 0;
    bool operator==(const Counted&) const = default;
  };
  std::vector<Counted> counted() const;
  // False, and nothing is added: the transition is there already, or its count is 0. REQUIRES: row and next below 2^32
  // times actions and 2^32.
  bool add(const Counted& transition);

  // Writes row_begin, successor and count of `parts` for `states` states. Errors: a count that reached 2^32.
  Result<void> fill(std::size_t states, ChainParts& parts) const;

 private:
  struct Slot {
    std::uint64_t key = 0;
    std::uint64_t count = 0;
  };

  void insert(std::uint64_t key, std::uint64_t count = 1);
  void grow();

  std::size_t actions_;
  std::size_t used_ = 0;
  unsigned shift_;
  std::vector<Slot> slots_;
};

}  // namespace coppice
