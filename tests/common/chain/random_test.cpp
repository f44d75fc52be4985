#include "common/chain/random.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <gtest/gtest.h>
#include <vector>

namespace coppice {
namespace {

// Known answers of Random123 1.09 (kat_vectors, philox4x32 with 10 rounds).
TEST(Philox, GivesTheKnownAnswers) {
  using Block = std::array<std::uint32_t, 4>;
  EXPECT_EQ(philox4x32({0, 0, 0, 0}, {0, 0}), (Block{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}));
  EXPECT_EQ(philox4x32({0xffffffff, 0xffffffff, 0xffffffff, 0xffffffff}, {0xffffffff, 0xffffffff}),
            (Block{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}));
  EXPECT_EQ(philox4x32({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0}),
            (Block{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}));
}

// A change of these values changes every result that Coppice ever gave: raise the study's schema with it.
TEST(Draw, IsPinned) {
  EXPECT_EQ(draw({1, Purpose::rollout, 0, 0, 0}), draw({1, Purpose::rollout, 0, 0, 0}));
  EXPECT_EQ(draw({1, Purpose::rollout, 2, 3, 4}), 9922248869530453420ULL);
  Xoshiro256 random(1);
  EXPECT_EQ(random.next(), 0xcfc5d07f6f03c29bULL);
}

TEST(DrawWords, AreTheWordsOfTheStreamsBlocks) {
  const DrawAt place{(std::uint64_t{9} << 32U) | 8, Purpose::rollout, 3, 5, 77};
  std::vector<std::uint32_t> words(10);
  draw_words(place, words);
  for (std::uint32_t i = 0; i < words.size(); ++i) {
    EXPECT_EQ(words[i], philox4x32({i / 4, 5, 3, static_cast<std::uint32_t>(Purpose::rollout)}, {8, 9})[i % 4]);
  }
}

TEST(Draw, DiffersInEveryCoordinate) {
  const DrawAt place{7, Purpose::rollout, 1, 1, 1};
  const std::uint64_t here = draw(place);
  EXPECT_NE(here, draw({8, Purpose::rollout, 1, 1, 1}));
  EXPECT_NE(here, draw({7 + (std::uint64_t{1} << 40U), Purpose::rollout, 1, 1, 1}));
  EXPECT_NE(here, draw({7, Purpose::mixing, 1, 1, 1}));
  EXPECT_NE(here, draw({7, Purpose::rollout, 2, 1, 1}));
  EXPECT_NE(here, draw({7, Purpose::rollout, 1, 2, 1}));
  EXPECT_NE(here, draw({7, Purpose::rollout, 1, 1, 2}));
}

// Chi-square with n - 1 degrees of freedom: mean n - 1, deviation sqrt(2 (n - 1)); six deviations above is a bug.
template <typename Below>
void expect_uniform(std::uint64_t n, const Below& below) {
  constexpr int kDraws = 200'000;
  std::vector<int> seen(n);
  for (int i = 0; i < kDraws; ++i) {
    const std::uint64_t value = below();
    ASSERT_LT(value, n);
    ++seen[value];
  }
  const double expected = static_cast<double>(kDraws) / static_cast<double>(n);
  double chi_square = 0.0;
  for (const int count : seen) {
    chi_square += (count - expected) * (count - expected) / expected;
  }
  const double degrees = static_cast<double>(n) - 1;
  EXPECT_LT(chi_square, degrees + 6 * std::sqrt(2 * degrees)) << "n = " << n;
}

TEST(Below, IsUniform) {
  for (const std::uint64_t n : {2ULL, 3ULL, 7ULL, 100ULL, 1041ULL}) {
    Stream stream(5, Purpose::breeding, 0, 0);
    expect_uniform(n, [&] { return stream.below(n); });
    Xoshiro256 random(n);
    expect_uniform(n, [&] { return random.below(n); });
  }
}

TEST(Accept, RefusesExactlyTheSurplusOfAnUnevenRange) {
  // With n = 3 x 2^62 every value of [0, n) must get the same number of x: 2^64 mod n = 2^62 of them are redrawn.
  const std::uint64_t n = std::uint64_t{3} << 62U;
  int refused = 0;
  constexpr int kDraws = 100'000;
  Xoshiro256 random(3);
  for (int i = 0; i < kDraws; ++i) {
    refused += accept(random.next(), n) ? 0 : 1;
  }
  EXPECT_NEAR(static_cast<double>(refused) / kDraws, 0.25, 0.01);
}

}  // namespace
}  // namespace coppice
