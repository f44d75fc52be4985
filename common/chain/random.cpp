#include "common/chain/random.hpp"

#include <algorithm>

namespace coppice {

std::array<std::uint32_t, 4> philox4x32(std::array<std::uint32_t, 4> counter, std::array<std::uint32_t, 2> key) {
  // Constants and round function: Salmon et al. 2011, Section 3.3 and Table 2.
  constexpr std::uint64_t kMultiplier0 = 0xD2511F53;
  constexpr std::uint64_t kMultiplier1 = 0xCD9E8D57;
  constexpr std::uint32_t kWeyl0 = 0x9E3779B9;
  constexpr std::uint32_t kWeyl1 = 0xBB67AE85;
  constexpr int kRounds = 10;
  for (int round = 0; round < kRounds; ++round) {
    const std::uint64_t product0 = kMultiplier0 * counter[0];
    const std::uint64_t product1 = kMultiplier1 * counter[2];
    counter = {static_cast<std::uint32_t>(product1 >> 32U) ^ counter[1] ^ key[0], static_cast<std::uint32_t>(product1),
               static_cast<std::uint32_t>(product0 >> 32U) ^ counter[3] ^ key[1], static_cast<std::uint32_t>(product0)};
    key[0] += kWeyl0;
    key[1] += kWeyl1;
  }
  return counter;
}

namespace {

std::array<std::uint32_t, 4> block_at(const DrawAt& place) {
  return philox4x32({place.position, place.stream, place.generation, static_cast<std::uint32_t>(place.purpose)},
                    {static_cast<std::uint32_t>(place.seed), static_cast<std::uint32_t>(place.seed >> 32U)});
}

}  // namespace

void draw_words(const DrawAt& place, std::span<std::uint32_t> out) {
  DrawAt at = place;
  at.position = 0;
  for (std::size_t begin = 0; begin < out.size(); begin += 4, ++at.position) {
    const auto block = block_at(at);
    std::copy_n(block.begin(), std::min<std::size_t>(block.size(), out.size() - begin),
                out.begin() + static_cast<std::ptrdiff_t>(begin));
  }
}

std::uint64_t draw(const DrawAt& place) {
  const auto block = block_at(place);
  return (static_cast<std::uint64_t>(block[1]) << 32U) | block[0];
}

std::uint64_t Stream::below(std::uint64_t n) {
  std::uint64_t x = next();
  while (!accept(x, n)) {
    x = next();
  }
  return scale(x, n);
}

Xoshiro256::Xoshiro256(std::uint64_t seed) : state_{} {
  for (std::uint64_t& word : state_) {
    seed += 0x9E3779B97F4A7C15;
    std::uint64_t mixed = seed;
    mixed = (mixed ^ (mixed >> 30U)) * 0xBF58476D1CE4E5B9;
    mixed = (mixed ^ (mixed >> 27U)) * 0x94D049BB133111EB;
    word = mixed ^ (mixed >> 31U);
  }
}

std::optional<Xoshiro256> Xoshiro256::from_state(const std::array<std::uint64_t, 4>& state) {
  if (state == std::array<std::uint64_t, 4>{}) {
    return std::nullopt;
  }
  Xoshiro256 random(0);
  random.state_ = state;
  return random;
}

}  // namespace coppice
