#include "common/tree/state_columns.hpp"

#include "common/tree/condition.hpp"

namespace coppice {
namespace {

constexpr std::size_t kWordBits = 64;

}  // namespace

StateColumns::StateColumns(const Vocabulary& vocabulary, std::span<const std::uint8_t> features)
    : states_(vocabulary.features.empty() ? 0 : features.size() / vocabulary.features.size()) {
  const std::size_t width = vocabulary.features.size();
  COPPICE_CHECK(states_ >= 1 && states_ * width == features.size());
  const std::size_t block_bits = kWordBits * kBlockWords;
  words_ = (states_ + block_bits - 1) / block_bits * kBlockWords;

  column_of_.assign(width * kOps * kValues, kUndeclared);
  std::uint32_t columns = 1;
  for (std::size_t feature = 0; feature < width; ++feature) {
    for (const Op op : {Op::equal, Op::less_equal}) {
      if (!vocabulary.features[feature].admits(op)) {
        continue;
      }
      for (const std::uint8_t value : vocabulary.features[feature].values) {
        column_of_[slot_of(feature, op, value)] = columns++;
      }
    }
  }

  bits_.assign(columns * words_, 0);
  for (std::size_t state = 0; state < states_; ++state) {
    const std::size_t word = state / kWordBits;
    const std::uint64_t bit = std::uint64_t{1} << (state % kWordBits);
    bits_[word] |= bit;
    for (std::size_t feature = 0; feature < width; ++feature) {
      const std::uint8_t read = features[state * width + feature];
      bool declared = false;
      for (const std::uint8_t value : vocabulary.features[feature].values) {
        declared = declared || value == read;
        for (const Op op : {Op::equal, Op::less_equal}) {
          const std::uint32_t column = column_of_[slot_of(feature, op, value)];
          if (column != kUndeclared && holds(op, read, value)) {
            bits_[column * words_ + word] |= bit;
          }
        }
      }
      COPPICE_CHECK(declared);
    }
  }
}

}  // namespace coppice
