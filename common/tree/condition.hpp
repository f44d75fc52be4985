// When a condition holds. Pure.
#pragma once

#include <cstdint>
#include <span>

#include "common/tree/node.hpp"

namespace coppice {

// Of a feature that reads `read`.
constexpr bool holds(Op op, std::uint8_t read, std::uint8_t value) {
  return op == Op::equal ? read == value : read <= value;
}

// REQUIRES: kind condition.
inline bool holds(const Node& condition, std::uint8_t read) { return holds(condition.op, read, condition.value); }

// REQUIRES: kind condition; features holds the one that it tests.
inline bool holds(const Node& condition, std::span<const std::uint8_t> features) {
  return holds(condition, features[condition.index]);
}

}  // namespace coppice
