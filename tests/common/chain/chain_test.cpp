#include "common/chain/chain.hpp"

#include <array>
#include <gtest/gtest.h>
#include <limits>
#include <map>

#include "common/chain/chain_builder.hpp"
#include "common/chain/chain_bytes.hpp"
#include "common/chain/random.hpp"
#include "tests/oracles/chains.hpp"

namespace coppice {
namespace {

ChainParts good_parts() { return oracles::random_chain({.states = 50, .actions = 3, .seed = 5}).parts(); }

// Each damage must be refused with a message that says what was found.
void expect_refused(const ChainParts& parts, const std::string& text) {
  const auto chain = Chain::make(parts);
  ASSERT_FALSE(chain.has_value()) << "expected: " << text;
  EXPECT_EQ(chain.error().kind, ErrorKind::bad_input);
  EXPECT_NE(chain.error().message.find(text), std::string::npos) << chain.error().message;
}

TEST(Chain, AcceptsGoodParts) { EXPECT_TRUE(Chain::make(good_parts()).has_value()); }

TEST(Chain, RefusesEveryBrokenPart) {
  ChainParts parts = good_parts();
  parts.successor[3] = 50;
  expect_refused(parts, "expected below 50");
  parts = good_parts();
  parts.count[0] = 0;
  expect_refused(parts, "count 0");
  parts = good_parts();
  parts.row_begin.back() -= 1;
  expect_refused(parts, "rows cover");
  parts = good_parts();
  parts.row_begin[5] = parts.row_begin[6] + 1;
  expect_refused(parts, "row");
  parts = good_parts();
  parts.q[7] = std::numeric_limits<double>::quiet_NaN();
  expect_refused(parts, "not finite");
  parts = good_parts();
  parts.features[0] = 2;
  expect_refused(parts, "reads 2");
  parts = good_parts();
  parts.policy[1] = ActionId{3};
  expect_refused(parts, "policy action 3");
  parts = good_parts();
  parts.initial_state = 50;
  expect_refused(parts, "initial state is 50");
  parts = good_parts();
  parts.visits.pop_back();
  expect_refused(parts, "visits has 49 entries");
  parts = good_parts();
  std::copy_n(parts.features.begin(), 6, parts.features.begin() + 6);
  expect_refused(parts, "same features");
  parts = good_parts();
  parts.vocabulary.actions[1] = "a0";
  expect_refused(parts, "used twice");
  parts = good_parts();
  parts.vocabulary.features[1].name = "bad name";
  expect_refused(parts, "malformed");
}

TEST(Chain, RefusesARowTriedTooOften) {
  ChainParts parts = good_parts();
  std::size_t row = 0;
  while (parts.row_begin[row + 1] - parts.row_begin[row] < 2) {
    ++row;
  }
  parts.count[parts.row_begin[row]] = std::numeric_limits<std::uint32_t>::max();
  expect_refused(parts, "expected below 2^32");
}

TEST(ChainBytes, RoundTrip) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Chain chain = oracles::random_chain({.states = static_cast<std::uint32_t>(1 + 30 * seed), .seed = seed});
    const auto bytes = to_bytes(chain);
    const auto back = chain_from_bytes(bytes);
    ASSERT_TRUE(back.has_value()) << back.error().message;
    EXPECT_EQ(back->parts(), chain.parts());
    EXPECT_EQ(hash_of(to_bytes(*back)), hash_of(bytes));
    EXPECT_EQ(*chain_hash_from_hex(hash_of(bytes).hex()), hash_of(bytes));
  }
}

TEST(ChainBytes, CanBeReadInPiecesOfAnySize) {
  const Chain chain = oracles::random_chain({.states = 200, .seed = 5});
  const auto bytes = to_bytes(chain);
  for (const std::size_t size : {std::size_t{1}, std::size_t{7}, std::size_t{4096}, bytes.size() - 1, bytes.size()}) {
    std::vector<std::vector<std::uint8_t>> pieces;
    for (std::size_t at = 0; at < bytes.size(); at += size) {
      const auto piece = std::span(bytes).subspan(at, std::min(size, bytes.size() - at));
      pieces.emplace_back(piece.begin(), piece.end());
    }
    EXPECT_EQ(hash_of(pieces), hash_of(bytes));
    const auto back = chain_from_pieces(pieces);
    ASSERT_TRUE(back.has_value()) << back.error().message;
    EXPECT_EQ(back->parts(), chain.parts());
    pieces.back().pop_back();
    if (!pieces.back().empty()) {
      EXPECT_FALSE(chain_from_pieces(pieces).has_value());
    }
  }
}

TEST(ChainBytes, RefusesEveryTruncation) {
  const auto bytes = to_bytes(oracles::random_chain({.states = 20, .seed = 3}));
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    EXPECT_FALSE(chain_from_bytes(std::span(bytes).first(length)).has_value()) << length;
  }
}

TEST(ChainBytes, NeitherCrashesOnNorMisreadsFlippedBytes) {
  auto bytes = to_bytes(oracles::random_chain({.states = 20, .seed = 3}));
  const ChainHash hash = hash_of(bytes);
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    bytes[i] ^= 0xFFU;
    EXPECT_NE(hash_of(bytes), hash);
    if (const auto chain = chain_from_bytes(bytes)) {
      EXPECT_EQ(to_bytes(*chain), bytes);
    }
    bytes[i] ^= 0xFFU;
  }
}

TEST(ChainBytes, TakesNoMemoryForSizesThatTheBytesDoNotHold) {
  auto bytes = to_bytes(oracles::knuth_die());
  // States stand after the vocabulary; a huge number there must be refused before anything is allocated.
  for (std::size_t at = 8; at + 8 < 200; ++at) {
    auto damaged = bytes;
    std::fill_n(damaged.begin() + static_cast<std::ptrdiff_t>(at), 4, std::uint8_t{0x0F});
    const auto chain = chain_from_bytes(damaged);
    EXPECT_TRUE(!chain || to_bytes(*chain) == damaged);
  }
}

TEST(ChainBuilder, CountsWhatItIsTold) {
  constexpr std::uint32_t kStates = 300;
  constexpr std::uint32_t kActions = 4;
  ChainBuilder builder(kActions);
  std::map<std::array<std::uint32_t, 3>, std::uint32_t> expected;
  Xoshiro256 random(9);
  for (int i = 0; i < 200'000; ++i) {
    const std::array<std::uint32_t, 3> key = {static_cast<std::uint32_t>(random.below(kStates)),
                                              static_cast<std::uint32_t>(random.below(kActions)),
                                              static_cast<std::uint32_t>(random.below(kStates))};
    builder.count(key[0], key[1], key[2]);
    ++expected[key];
  }
  ChainParts parts;
  ASSERT_TRUE(builder.fill(kStates, parts).has_value());
  ASSERT_EQ(parts.successor.size(), expected.size());
  std::size_t at = 0;
  for (const auto& [key, count] : expected) {  // in the order of rows and successors
    const std::uint64_t row = key[0] * kActions + key[1];
    EXPECT_LE(parts.row_begin[row], at);
    EXPECT_GT(parts.row_begin[row + 1], at);
    EXPECT_EQ(parts.successor[at], key[2]);
    EXPECT_EQ(parts.count[at], count);
    ++at;
  }
}

TEST(GreedyPolicy, BreaksTiesToTheLowestAction) {
  const std::vector<double> q = {1, 2, 2, 0, 0, 0, -1, -3, -1};
  const auto policy = greedy_policy(q, 3);
  EXPECT_EQ(policy, (std::vector<ActionId>{ActionId{1}, ActionId{0}, ActionId{0}}));
}

}  // namespace
}  // namespace coppice
