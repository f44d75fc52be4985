// Draws from the counts' posterior against the moments of the Dirichlet and the gamma distribution.
#include "common/chain/count_posterior.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>

#include "tests/oracles/chains.hpp"

namespace coppice {
namespace {

constexpr int kDraws = 40'000;

TEST(CountPosterior, GammaHasMeanAndVarianceOfItsShape) {
  const Chain chain = oracles::knuth_die();
  for (const double shape : {1.0, 2.5, 40.0, 1e6}) {
    CountPosterior posterior(chain, 7);
    double sum = 0.0;
    double squares = 0.0;
    for (int i = 0; i < kDraws; ++i) {
      const double x = posterior.gamma(shape);
      ASSERT_GT(x, 0.0);
      sum += x;
      squares += (x - shape) * (x - shape);
    }
    EXPECT_NEAR(sum / kDraws, shape, 5.0 * std::sqrt(shape / kDraws)) << shape;
    // The variance of a sample variance: (kurtosis - 1) / n, with 3 + 6 / shape for a gamma.
    EXPECT_NEAR(squares / kDraws / shape, 1.0, 5.0 * std::sqrt((2.0 + 6.0 / shape) / kDraws)) << shape;
  }
}

TEST(CountPosterior, ARowIsDrawnFromTheDirichletOfItsCounts) {
  const Chain chain = oracles::random_chain({.states = 40, .actions = 2, .seed = 3});
  std::size_t row = 0;
  while (chain.successors(row).size() < 3) {  // a random chain of this size has many
    ++row;
  }
  const std::array<std::size_t, 1> rows{row};
  const std::size_t begin = chain.parts().row_begin[rows[0]];
  const auto tries = static_cast<double>(chain.tries(rows[0]));
  std::vector<double> probabilities(chain.transitions(), -1.0);
  CountPosterior posterior(chain, 11);
  const std::size_t size = chain.successors(rows[0]).size();
  std::vector<double> sum(size, 0.0);
  std::vector<double> squares(size, 0.0);
  for (int i = 0; i < kDraws; ++i) {
    posterior.draw(rows, probabilities);
    double total = 0.0;
    for (std::size_t j = 0; j < size; ++j) {
      const double p = static_cast<double>(chain.counts(rows[0])[j]) / tries;
      total += probabilities[begin + j];
      sum[j] += probabilities[begin + j];
      squares[j] += (probabilities[begin + j] - p) * (probabilities[begin + j] - p);
    }
    ASSERT_NEAR(total, 1.0, 1e-12);
  }
  for (std::size_t j = 0; j < size; ++j) {
    const double p = static_cast<double>(chain.counts(rows[0])[j]) / tries;
    const double variance = p * (1.0 - p) / (tries + 1.0);
    EXPECT_NEAR(sum[j] / kDraws, p, 5.0 * std::sqrt(variance / kDraws));
    EXPECT_NEAR(squares[j] / kDraws / variance, 1.0, 0.1);
  }
  EXPECT_EQ(std::count(probabilities.begin(), probabilities.end(), -1.0),
            static_cast<std::ptrdiff_t>(chain.transitions() - size))
      << "other rows stay as they are";
}

TEST(CountPosterior, TheSameSeedGivesTheSameDraws) {
  const Chain chain = oracles::gamblers_ruin({});
  const std::vector<std::size_t> rows{1, 2, 3};
  std::vector<double> first(chain.transitions(), 0.0);
  std::vector<double> second(chain.transitions(), 0.0);
  CountPosterior(chain, 5).draw(rows, first);
  CountPosterior(chain, 5).draw(rows, second);
  EXPECT_EQ(first, second);
  CountPosterior(chain, 6).draw(rows, second);
  EXPECT_NE(first, second);
}

TEST(MissingMass, IsTheShareOfTriesThatWereTheOnlyOneOfTheirKind) {
  ChainParts parts;
  parts.vocabulary.features = {{"f", {0, 1, 2}}};
  parts.vocabulary.actions = {"go"};
  parts.features = {0, 1, 2};
  parts.row_begin = {0, 3, 4, 4};
  parts.successor = {0, 1, 2, 0};
  parts.count = {1, 1, 6, 5};
  parts.reward_sum = parts.q = {0.0, 0.0, 0.0};
  parts.policy = {ActionId{0}, ActionId{0}, ActionId{0}};
  parts.visits = {8, 5, 0};
  const auto chain = Chain::make(std::move(parts));
  ASSERT_TRUE(chain) << chain.error().message;
  EXPECT_EQ(missing_mass(*chain, 0), 0.25);
  EXPECT_EQ(missing_mass(*chain, 1), 0.0);
}

}  // namespace
}  // namespace coppice
