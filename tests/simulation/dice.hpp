// Chance for the simulation: integers only, the same everywhere, and keyed, so that a draw belongs to its place and not
// to the order of drawing: taking one fault out leaves all other draws as they were.
#pragma once

#include <cstdint>

#include "common/chain/random.hpp"

namespace coppice::simulation {

// SplitMix64 (Steele, Lea, Flood 2014), as a hash of its keys.
constexpr std::uint64_t mixed(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15ULL;
  x = (x ^ (x >> 30U)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27U)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31U);
}
template <typename... Keys>
constexpr std::uint64_t hash(std::uint64_t first, Keys... keys) {
  std::uint64_t value = mixed(first);
  ((value = mixed(value ^ static_cast<std::uint64_t>(keys))), ...);
  return value;
}

class Dice {
 public:
  explicit Dice(std::uint64_t seed) : state_(seed) {}
  std::uint64_t next() { return mixed(state_++); }
  // In [0, n). REQUIRES: n >= 1. The bias is below 2^-32 for the n that occur.
  std::uint64_t below(std::uint64_t n) { return static_cast<std::uint64_t>((static_cast<Uint128>(next()) * n) >> 64U); }
  std::uint64_t between(std::uint64_t low, std::uint64_t high) { return low + below(high - low + 1); }
  bool one_in(std::uint64_t n) { return below(n) == 0; }
  // Small values as likely as large ones: every power of two of the range has the same share.
  std::uint64_t of_any_size(std::uint64_t low, std::uint64_t high) {
    unsigned bits = 0;
    while ((high / low) >> (bits + 1) != 0) {
      ++bits;
    }
    const std::uint64_t top = low << below(bits + 1U);
    return between(low, top < high / 2 ? top * 2 : high);
  }

 private:
  std::uint64_t state_;
};

}  // namespace coppice::simulation
