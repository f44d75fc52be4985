#include "common/chain/chain_builder.hpp"

#include <algorithm>
#include <bit>
#include <fmt/format.h>
#include <tuple>

#include "common/check.hpp"

namespace coppice {
namespace {

constexpr std::size_t kFirstSlots = std::size_t{1} << 12U;

unsigned shift_for(std::size_t slots) { return 64U - static_cast<unsigned>(std::countr_zero(slots)); }

}  // namespace

ChainBuilder::ChainBuilder(std::size_t actions)
    : actions_(actions), shift_(shift_for(kFirstSlots)), slots_(kFirstSlots) {}

void ChainBuilder::insert(std::uint64_t key, std::uint64_t count) {
  if (2 * (used_ + 1) > slots_.size()) {
    grow();
  }
  std::size_t slot = static_cast<std::size_t>((key * 0x9E3779B97F4A7C15) >> shift_);
  while (slots_[slot].key != 0) {
    slot = (slot + 1) & (slots_.size() - 1);
  }
  slots_[slot] = {key, count};
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

std::vector<ChainBuilder::Counted> ChainBuilder::counted() const {
  std::vector<Counted> sorted;
  sorted.reserve(used_);
  for (const Slot& slot : slots_) {
    if (slot.key != 0) {
      sorted.push_back({(slot.key - 1) >> 32U, (slot.key - 1) & 0xFFFFFFFFU, slot.count});
    }
  }
  std::sort(sorted.begin(), sorted.end(),
            [](const Counted& a, const Counted& b) { return std::tie(a.row, a.next) < std::tie(b.row, b.next); });
  return sorted;
}

bool ChainBuilder::add(const Counted& transition) {
  const std::uint64_t key = (transition.row << 32U | transition.next) + 1;
  if (transition.count == 0) {
    return false;
  }
  std::size_t slot = static_cast<std::size_t>((key * 0x9E3779B97F4A7C15) >> shift_);
  while (slots_[slot].key != 0) {
    if (slots_[slot].key == key) {
      return false;
    }
    slot = (slot + 1) & (slots_.size() - 1);
  }
  insert(key, transition.count);
  return true;
}

Result<void> ChainBuilder::fill(std::size_t states, ChainParts& parts) const {
  const std::size_t rows = states * actions_;
  parts.row_begin.assign(rows + 1, 0);
  parts.successor.clear();
  parts.count.clear();
  for (const auto& [row, next, count] : counted()) {
    COPPICE_CHECK(row < rows);
    if (count >> 32U != 0) {
      return bad_input(fmt::format("row {} counted one successor {} times: expected below 2^32", row, count));
    }
    parts.successor.push_back(static_cast<std::uint32_t>(next));
    parts.count.push_back(static_cast<std::uint32_t>(count));
    ++parts.row_begin[row + 1];
  }
  for (std::size_t row = 0; row < rows; ++row) {
    parts.row_begin[row + 1] += parts.row_begin[row];
  }
  return {};
}

}  // namespace coppice
