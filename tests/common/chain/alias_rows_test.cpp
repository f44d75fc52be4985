#include "common/chain/alias_rows.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <map>
#include <vector>

#include "common/chain/lazy_row.hpp"
#include "tests/oracles/chains.hpp"

namespace coppice {
namespace {

std::uint64_t never_more(std::uint32_t) {
  ADD_FAILURE() << "asked for more bits";
  return 0;
}

// A chain whose rows are small enough to enumerate.
Chain small_counts_chain() {
  ChainParts parts = oracles::random_chain({.states = 100, .actions = 3, .seed = 21}).parts();
  for (std::uint32_t& count : parts.count) {
    count = 1 + count % 50;
  }
  return std::move(*Chain::make(std::move(parts)));
}

// Exactness: over all units of a row every successor has exactly count x bins of them.
TEST(AliasBins, HoldTheCountsExactly) {
  const Chain chain = small_counts_chain();
  std::vector<AliasBin> bins;
  for (std::size_t row = 0; row < chain.states() * chain.actions(); ++row) {
    const auto successors = chain.successors(row);
    const auto counts = chain.counts(row);
    if (successors.empty()) {
      continue;
    }
    const auto units = static_cast<std::uint32_t>(chain.tries(row));
    bins.resize(successors.size());
    fill_bins(successors, counts, units, bins);
    std::map<std::uint32_t, std::uint64_t> owned;
    for (const AliasBin& bin : bins) {
      ASSERT_LE(bin.threshold, units);
      owned[bin.successor] += bin.threshold;
      owned[bin.alias] += units - bin.threshold;
    }
    for (std::size_t i = 0; i < successors.size(); ++i) {
      EXPECT_EQ(owned[successors[i]], std::uint64_t{counts[i]} * successors.size());
    }
  }
}

// All 2^32 x kN combinations are too many; with 32 bits replaced by fewer, the law behind unit_of() is enumerated: u =
// (x M + v) >> bits is even over [0, M) when x is over 2^bits and v over M.
TEST(AliasBins, UnitsAreEvenOverAllBits) {
  constexpr std::uint32_t kBins = 7;
  constexpr std::uint32_t kUnits = 13;
  constexpr std::uint64_t kAll = kBins * kUnits;
  std::map<std::uint64_t, int> seen;
  for (std::uint64_t x = 0; x < 256; ++x) {
    for (std::uint64_t v = 0; v < kAll; ++v) {
      // The middle of the bits that scale() maps to v.
      const auto bits = static_cast<std::uint64_t>(((static_cast<Uint128>(2 * v + 1) << 63U) + kAll - 1) / kAll);
      const auto top = static_cast<std::uint32_t>(x << 24U);
      const std::uint64_t from_top = unit_of(top, kBins, kUnits, [&](std::uint32_t) { return bits; });
      ASSERT_EQ(from_top, ((std::uint64_t{top} * kAll + v) >> 32U));
      ++seen[(x * kAll + v) >> 8U];
    }
  }
  ASSERT_EQ(seen.size(), kAll);
  for (const auto& [unit, count] : seen) {
    EXPECT_EQ(count, 256) << unit;
  }
}

TEST(AliasBins, DrawAgainWhatWouldMakeUnitsUneven) {
  // 2^64 mod 9 = 7 values are surplus; 0 is one of them.
  std::vector<std::uint32_t> attempts;
  const std::uint64_t unit = unit_of(0x80000000U, 3, 3, [&](std::uint32_t attempt) {
    attempts.push_back(attempt);
    return attempt == 0 ? 0 : std::uint64_t{1} << 63U;
  });
  EXPECT_EQ(attempts, (std::vector<std::uint32_t>{0, 1}));
  EXPECT_EQ(unit, 4U);  // (2^31 x 9 + 4) >> 32
}

// Around every edge of every bin: where x alone decides, all further bits give that successor.
TEST(AliasRows, DecideEarlyOnlyWhatFurtherBitsCannotChange) {
  const Chain chain = small_counts_chain();
  const AliasRows rows(chain);
  int careful = 0;
  for (std::size_t state = 0; state < chain.states(); ++state) {
    for (std::size_t action = 0; action <= chain.actions(); ++action) {
      const PackedRow row = rows.row(state, action);
      const std::uint32_t bins = bins_of(row);
      for (std::uint32_t bin = 0; bin < bins; ++bin) {
        const auto cutoff = static_cast<std::uint32_t>(rows.bins()[begin_of(row) + bin] >> 32U);
        const std::uint64_t begin = (std::uint64_t{bin} << 32U) / bins;
        for (const std::uint64_t edge : {begin, begin + cutoff / bins}) {
          for (std::int64_t off = -3; off <= 3; ++off) {
            const auto x = static_cast<std::uint32_t>(edge + static_cast<std::uint64_t>(off));
            bool asked = false;
            const std::uint32_t early = rows.sample(row, x, [&](std::uint32_t) {
              asked = true;
              return std::uint64_t{1} << 40U;
            });
            careful += asked ? 1 : 0;
            if (!asked) {
              for (const std::uint64_t bits : {std::uint64_t{1} << 40U, ~std::uint64_t{0} >> 1U, ~std::uint64_t{0}}) {
                ASSERT_EQ(early, rows.sample_carefully(row, x, [&](std::uint32_t) { return bits; }));
              }
            }
          }
        }
      }
    }
  }
  EXPECT_GT(careful, 100);
}

TEST(AliasRows, SampleWithTheFrequenciesOfTheCounts) {
  const Chain chain = oracles::random_chain({.states = 60, .actions = 2, .seed = 4});
  const AliasRows rows(chain);
  Xoshiro256 random(17);
  constexpr int kDraws = 100'000;
  for (std::size_t row = 0; row < 20; ++row) {
    if (chain.tries(row) == 0) {
      continue;
    }
    std::map<std::uint32_t, int> seen;
    for (int i = 0; i < kDraws; ++i) {
      ++seen[rows.sample(rows.row(row / 2, row % 2), static_cast<std::uint32_t>(random.next() >> 32U),
                         [&](std::uint32_t) { return random.next(); })];
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
  const AliasRows rows(chain);
  std::map<std::uint32_t, int> seen;
  Xoshiro256 random(1);
  for (int i = 0; i < 30'000; ++i) {
    ++seen[rows.sample(rows.row(row / 3, row % 3), static_cast<std::uint32_t>(random.next() >> 32U),
                       [&](std::uint32_t) { return random.next(); })];
  }
  ASSERT_EQ(seen.size(), 30U);
  for (const auto& [state, count] : seen) {
    EXPECT_NEAR(count, 1000, 200) << "state " << state;
  }
}

TEST(AliasRows, StayPutWithoutAnAction) {
  const Chain chain = oracles::random_chain({.states = 30, .actions = 3, .seed = 2});
  const AliasRows rows(chain);
  for (std::uint32_t state = 0; state < 30; ++state) {
    EXPECT_EQ(rows.sample(rows.row(state, 3), 0x12345678U * (state + 1), never_more), state);
  }
}

TEST(LazyRow, GivesWhatTheAliasRowsGive) {
  const Chain chain = oracles::random_chain({.states = 120, .actions = 3, .seed = 9});
  const AliasRows rows(chain);
  LazyRow lazy;
  Xoshiro256 random(5);
  for (std::uint32_t state = 0; state < 120; ++state) {
    for (std::size_t action = 0; action <= 3; ++action) {
      for (int i = 0; i < 300; ++i) {
        // Also bits that do not decide: the edges of the bins.
        const std::uint32_t bins = bins_of(rows.row(state, action));
        const auto edge = static_cast<std::uint32_t>((random.below(bins) << 32U) / bins);
        const auto x = i % 3 == 0 ? edge : static_cast<std::uint32_t>(random.next() >> 32U);
        const std::uint64_t bits = random.next() | 1U;
        const auto more = [&](std::uint32_t attempt) { return bits + attempt; };
        ASSERT_EQ(lazy.sample(chain, state, action, x, more), rows.sample(rows.row(state, action), x, more));
      }
    }
  }
}

}  // namespace
}  // namespace coppice
