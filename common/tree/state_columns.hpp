// The states of a chain turned on their side: for every condition that the vocabulary allows, one bit per state
// that says whether it holds there. A tree is then evaluated on 64 states with one instruction. Immutable;
// safe to share between threads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/check.hpp"
#include "common/tree/node.hpp"
#include "common/tree/vocabulary.hpp"

namespace coppice {

class StateColumns {
 public:
  // features: [states x features of the vocabulary], row-major. REQUIRES: states >= 1, values as declared by the
  // vocabulary.
  StateColumns(const Vocabulary& vocabulary, std::span<const std::uint8_t> features);

  std::size_t states() const { return states_; }
  // Words of 64 states in each column, padded to a multiple of kBlockWords; padding bits are 0.
  std::size_t words() const { return words_; }
  // The bits of a condition node: bit (s % 64) of word (s / 64) for state s.
  // REQUIRES: the condition passed check_tree() for the vocabulary.
  const std::uint64_t* column(const Node& condition) const {
    const std::size_t slot = slot_of(condition.index, condition.op, condition.value);
    COPPICE_CHECK(condition.kind == NodeKind::condition && slot < column_of_.size() && column_of_[slot] != kUndeclared);
    return bits_.data() + column_of_[slot] * words_;
  }
  // The column of all states: 1 in the first states() bits, 0 in the padding.
  const std::uint64_t* all() const { return bits_.data(); }

  static constexpr std::size_t kBlockWords = 8;

 private:
  static constexpr std::size_t kOps = 2;
  static constexpr std::size_t kValues = 256;
  static constexpr std::uint32_t kUndeclared = UINT32_MAX;
  static std::size_t slot_of(std::size_t feature, Op op, std::uint8_t value) {
    return (feature * kOps + static_cast<std::size_t>(op)) * kValues + value;
  }

  std::size_t states_ = 0;
  std::size_t words_ = 0;
  std::vector<std::uint64_t> bits_;       // column 0 is all()
  std::vector<std::uint32_t> column_of_;  // [features x ops x 256], index of a column in bits_
};

}  // namespace coppice
