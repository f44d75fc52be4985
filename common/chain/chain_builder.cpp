#include "common/chain/chain_builder.hpp"

#include <algorithm>
#include <bit>
#include <fmt/format.h>

#include "common/check.hpp"

namespace coppice {
namespace {

constexpr std::size_t kFirstSlots = std::size_t{1} << 12U;

unsigned shift_for(std::size_t slots) { return 64U - static_cast<unsigned>(std::countr_zero(slots)); }

}  // namespace

ChainBuilder::ChainBuilder(std::size_t actions)
    : actions_(actions), shift_(shift_for(kFirstSlots)), slots_(kFirstSlots) {}

void ChainBuilder::insert(std::uint64_t key) {
  if (2 * (used_ + 1) > slots_.size()) {
    grow();
  }
  std::size_t slot = static_cast<std::size_t>((key * 0x9E3779B97F4A7C15) >> shift_);
  while (slots_[slot].key != 0) {
    slot = (slot + 1) & (slots_.size() - 1);
  }
  slots_[slot] = {key, 1};
  ++used_;
}

void ChainBuilder::grow() {
  std::vector<Slot> old(slots_.size() * 2);
  old.swap(slots_);
  shift_ = shift_for(slots_.size());
  for (const Slot& entry : old) {
    if (entry.key != 0) {
      std::size_t slot = static_cast<std::size_t>((entry.key * 0x9E3779B97F4A7C15) >> shift_);
      while (slots_[slot].key != 0) {
        slot = (slot + 1) & (slots_.size() - 1);
      }
      slots_[slot] = entry;
    }
  }
}

Result<void> ChainBuilder::fill(std::size_t states, ChainParts& parts) const {
  std::vector<Slot> sorted;
  sorted.reserve(used_);
  std::copy_if(slots_.begin(), slots_.end(), std::back_inserter(sorted),
               [](const Slot& slot) { return slot.key != 0; });
  std::sort(sorted.begin(), sorted.end(), [](const Slot& a, const Slot& b) { return a.key < b.key; });
  const std::size_t rows = states * actions_;
  parts.row_begin.assign(rows + 1, 0);
  parts.successor.clear();
  parts.count.clear();
  for (const Slot& slot : sorted) {
    const std::uint64_t row = (slot.key - 1) >> 32U;
    COPPICE_CHECK(row < rows);
    if (slot.count >> 32U != 0) {
      return bad_input(fmt::format("row {} counted one successor {} times: expected below 2^32", row, slot.count));
    }
    parts.successor.push_back(static_cast<std::uint32_t>(slot.key - 1));
    parts.count.push_back(static_cast<std::uint32_t>(slot.count));
    ++parts.row_begin[row + 1];
  }
  for (std::size_t row = 0; row < rows; ++row) {
    parts.row_begin[row + 1] += parts.row_begin[row];
  }
  return {};
}

}  // namespace coppice
