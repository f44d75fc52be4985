#include "common/chain/alias_rows.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <map>

#include "tests/oracles/chains.hpp"

namespace coppice {
namespace {

std::uint64_t never_redraw(std::uint32_t) {
  ADD_FAILURE() << "redrawn";
  return 0;
}

// Exactness: all bins x units of a row, enumerated, give every successor exactly count x bins times.
TEST(AliasRows, ReproduceTheCountsExactly) {
  ChainParts parts = oracles::random_chain({.states = 100, .actions = 3, .seed = 21}).parts();
  for (std::uint32_t& count : parts.count) {
    count = 1 + count % 50;  // small enough to enumerate
  }
  const auto chain = Chain::make(std::move(parts));
  ASSERT_TRUE(chain.has_value());
  const auto rows = AliasRows::make(*chain);
  ASSERT_TRUE(rows.has_value());
  for (std::size_t state = 0; state < chain->states(); ++state) {
    for (std::size_t action = 0; action < chain->actions(); ++action) {
      const std::size_t row = state * chain->actions() + action;
      if (chain->tries(row) == 0) {
        continue;
      }
      const AliasRow& alias = rows->row(state, action);
      const std::uint64_t total = std::uint64_t{alias.bins} * alias.units;
      ASSERT_EQ(alias.units, chain->tries(row));
      std::map<std::uint32_t, std::uint64_t> seen;
      for (std::uint64_t v = 0; v < total; ++v) {
        // The middle of the x that scale() maps to v.
        const auto x = static_cast<std::uint64_t>(((static_cast<Uint128>(2 * v + 1) << 63U) + total - 1) / total);
        ++seen[rows->sample(state, action, x, never_redraw)];
      }
      const auto successors = chain->successors(row);
      const auto counts = chain->counts(row);
      ASSERT_EQ(seen.size(), successors.size());
      for (std::size_t i = 0; i < successors.size(); ++i) {
        EXPECT_EQ(seen[successors[i]], std::uint64_t{counts[i]} * successors.size());
      }
    }
  }
}

TEST(AliasRows, SampleWithTheFrequenciesOfTheCounts) {
  const Chain chain = oracles::random_chain({.states = 60, .actions = 2, .seed = 4});
  const auto rows = AliasRows::make(chain);
  Xoshiro256 random(17);
  constexpr int kDraws = 100'000;
  for (std::size_t row = 0; row < 20; ++row) {
    if (chain.tries(row) == 0) {
      continue;
    }
    std::map<std::uint32_t, int> seen;
    for (int i = 0; i < kDraws; ++i) {
      ++seen[rows->sample(row / 2, row % 2, random.next(), [&](std::uint32_t) { return random.next(); })];
    }
    const auto successors = chain.successors(row);
    double chi_square = 0.0;
    for (std::size_t i = 0; i < successors.size(); ++i) {
      const double expected =
          kDraws * static_cast<double>(chain.counts(row)[i]) / static_cast<double>(chain.tries(row));
      chi_square += (seen[successors[i]] - expected) * (seen[successors[i]] - expected) / expected;
    }
    const double degrees = static_cast<double>(successors.size()) - 1;
    EXPECT_LE(chi_square, degrees + 6 * std::sqrt(2 * degrees) + 1e-9) << "row " << row;
  }
}

TEST(AliasRows, LeadAnywhereFromAPairNeverTried) {
  const Chain chain = oracles::random_chain({.states = 30, .actions = 3, .seed = 2});
  std::size_t row = 0;
  while (row < 90 && chain.tries(row) != 0) {
    ++row;
  }
  ASSERT_LT(row, 90U);
  const auto rows = AliasRows::make(chain);
  std::map<std::uint32_t, int> seen;
  Xoshiro256 random(1);
  for (int i = 0; i < 30'000; ++i) {
    ++seen[rows->sample(row / 3, row % 3, random.next(), [&](std::uint32_t) { return random.next(); })];
  }
  ASSERT_EQ(seen.size(), 30U);
  for (const auto& [state, count] : seen) {
    EXPECT_NEAR(count, 1000, 200) << "state " << state;
  }
}

TEST(AliasRows, StayPutWithoutAnAction) {
  const Chain chain = oracles::random_chain({.states = 30, .actions = 3, .seed = 2});
  const auto rows = AliasRows::make(chain);
  Xoshiro256 random(1);
  for (std::uint32_t state = 0; state < 30; ++state) {
    EXPECT_EQ(rows->sample(state, 3, random.next(), never_redraw), state);
  }
}

TEST(AliasRows, RedrawWhatWouldMakeARowUneven) {
  // Three successors of one count each: 2^64 mod 9 = 7 values of x are surplus; x = 0 is one of them.
  ChainParts parts = oracles::random_chain({.states = 10, .actions = 1, .seed = 1}).parts();
  parts.successor = {1, 2, 3};
  parts.count = {1, 1, 1};
  parts.row_begin.assign(11, 3);
  parts.row_begin[0] = 0;
  const auto chain = Chain::make(std::move(parts));
  ASSERT_TRUE(chain.has_value()) << chain.error().message;
  const auto rows = AliasRows::make(*chain);
  int redraws = 0;
  const std::uint32_t next = rows->sample(0, 0, 0, [&](std::uint32_t attempt) {
    EXPECT_EQ(attempt, 1U);
    ++redraws;
    return std::uint64_t{1} << 63U;
  });
  EXPECT_EQ(redraws, 1);
  EXPECT_EQ(next, 2U);  // the middle of the range
}

}  // namespace
}  // namespace coppice
