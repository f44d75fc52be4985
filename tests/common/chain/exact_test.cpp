// ExactOccupancy against closed forms, and against a dense matrix on random chains.
#include "common/chain/exact.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numeric>
#include <string>

#include "common/chain/exact_classes.hpp"
#include "common/chain/random.hpp"
#include "tests/oracles/chains.hpp"

namespace coppice {
namespace {

using Vector = std::vector<double>;
using Matrix = std::vector<Vector>;

Vector by_state(const Occupancy& occupancy, std::size_t states) {
  Vector visits(states, 0.0);
  EXPECT_EQ(occupancy.states.size(), occupancy.visits.size());
  for (std::size_t i = 0; i < occupancy.states.size(); ++i) {
    EXPECT_EQ(visits.at(occupancy.states[i]), 0.0) << "a state is listed twice";
    visits[occupancy.states[i]] = occupancy.visits[i];
  }
  return visits;
}

void expect_near(const Vector& found, const Vector& expected, double tolerance) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t s = 0; s < found.size(); ++s) {
    ASSERT_NEAR(found[s], expected[s], tolerance) << "state " << s;
  }
}

// The dense reference: the matrix itself, with the row of an untried pair written out.
Matrix dense(const Chain& chain, const ActingTables& acting) {
  const std::size_t states = chain.states();
  Matrix p(states, Vector(states, 0.0));
  const auto add = [&](std::size_t state, std::uint8_t action, double share) {
    if (action == chain.actions()) {
      p[state][state] += share;
      return;
    }
    const std::size_t row = state * chain.actions() + action;
    if (chain.tries(row) == 0) {
      for (double& entry : p[state]) {
        entry += share / static_cast<double>(states);
      }
      return;
    }
    for (std::size_t i = 0; i < chain.successors(row).size(); ++i) {
      p[state][chain.successors(row)[i]] += share * chain.counts(row)[i] / static_cast<double>(chain.tries(row));
    }
  };
  for (std::size_t s = 0; s < states; ++s) {
    add(s, acting.actions[s], 1.0 - acting.others_share);
    if (acting.others_share > 0.0) {
      add(s, acting.others[s], acting.others_share);
    }
  }
  return p;
}

Matrix product(const Matrix& a, const Matrix& b) {
  Matrix c(a.size(), Vector(a.size(), 0.0));
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t k = 0; k < a.size(); ++k) {
      for (std::size_t j = 0; j < a.size(); ++j) {
        c[i][j] += a[i][k] * b[k][j];
      }
    }
  }
  return c;
}

// sum over i of weight^i P(X_i = s), i < steps
Vector dense_sum(const Matrix& p, std::size_t from, std::size_t steps, double weight) {
  Vector now(p.size(), 0.0);
  Vector sum(p.size(), 0.0);
  now[from] = 1.0;
  for (std::size_t step = 0; step < steps; ++step) {
    Vector next(p.size(), 0.0);
    for (std::size_t s = 0; s < p.size(); ++s) {
      sum[s] += now[s];
      for (std::size_t to = 0; to < p.size(); ++to) {
        next[to] += weight * now[s] * p[s][to];
      }
    }
    now = next;
  }
  return sum;
}

// Mean of the first 2^40 powers, by doubling: A(2n) = (A(n) + P^n A(n)) / 2.
Vector dense_long_run(const Matrix& p, std::size_t from) {
  Matrix mean(p.size(), Vector(p.size(), 0.0));
  for (std::size_t s = 0; s < p.size(); ++s) {
    mean[s][s] = 1.0;
  }
  Matrix power = p;
  for (int doubling = 0; doubling < 40; ++doubling) {
    const Matrix later = product(power, mean);
    for (std::size_t i = 0; i < p.size(); ++i) {
      for (std::size_t j = 0; j < p.size(); ++j) {
        mean[i][j] = (mean[i][j] + later[i][j]) / 2.0;
      }
    }
    power = product(power, power);
    for (Vector& row : power) {  // 2^40 roundings would add up
      const double sum = std::accumulate(row.begin(), row.end(), 0.0);
      for (double& entry : row) {
        entry /= sum;
      }
    }
  }
  return mean[from];
}

struct Tables {
  std::vector<std::uint8_t> actions;
  std::vector<std::uint8_t> others;
};

// Actions at random; with_none: none in one state of four.
Tables random_tables(const Chain& chain, std::uint64_t seed, bool with_none) {
  Xoshiro256 random(seed);
  Tables tables;
  for (auto* table : {&tables.actions, &tables.others}) {
    for (std::size_t s = 0; s < chain.states(); ++s) {
      const bool none = with_none && random.below(4) == 0;
      table->push_back(static_cast<std::uint8_t>(none ? chain.actions() : random.below(chain.actions())));
    }
  }
  return tables;
}

// The same chain with every row that was never tried leading back to its own state.
Chain tried_everywhere(const Chain& chain) {
  ChainParts parts = chain.parts();
  std::vector<std::uint64_t> begin = {0};
  std::vector<std::uint32_t> successor;
  std::vector<std::uint32_t> count;
  for (std::size_t row = 0; row < chain.states() * chain.actions(); ++row) {
    for (std::size_t i = 0; i < chain.successors(row).size(); ++i) {
      successor.push_back(chain.successors(row)[i]);
      count.push_back(chain.counts(row)[i]);
    }
    if (chain.tries(row) == 0) {
      successor.push_back(static_cast<std::uint32_t>(row / chain.actions()));
      count.push_back(1);
    }
    begin.push_back(successor.size());
  }
  parts.row_begin = begin;
  parts.successor = successor;
  parts.count = count;
  auto made = Chain::make(std::move(parts));
  EXPECT_TRUE(made.has_value());
  return *made;
}

struct Case {
  std::string name;
  Chain chain;
  Tables tables;
  double others_share;

  ActingTables acting() const { return {tables.actions, tables.others, others_share}; }
};

std::vector<Case> random_cases(std::uint32_t states, std::uint64_t seeds) {
  std::vector<Case> cases;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    const Chain untried = oracles::random_chain({.states = states, .actions = 3, .seed = seed});
    for (const Chain& chain : {untried, tried_everywhere(untried)}) {
      for (const double share : {0.0, 0.25, 1.0}) {
        const bool none = seed % 2 == 0;
        cases.push_back({"seed " + std::to_string(seed) + " others " + std::to_string(share), chain,
                         random_tables(chain, seed, none), share});
      }
    }
  }
  return cases;
}

TEST(ExactOccupancy, OverStepsIsTheSumOfThePowersOfADenseMatrix) {
  for (const Case& c : random_cases(60, 8)) {
    SCOPED_TRACE(c.name);
    ExactOccupancy exact(c.chain);
    for (const std::uint32_t steps : {1U, 2U, 3U, 40U}) {
      const Vector expected = dense_sum(dense(c.chain, c.acting()), c.chain.initial_state(), steps, 1.0);
      expect_near(by_state(exact.over_steps(c.acting(), steps), 60), expected, 1e-12 * steps);
    }
  }
}

TEST(ExactOccupancy, DiscountedIsTheWeightedSumOfThePowersOfADenseMatrix) {
  for (const Case& c : random_cases(60, 8)) {
    SCOPED_TRACE(c.name);
    ExactOccupancy exact(c.chain);
    for (const double gamma : {0.0, 0.3, 0.97}) {
      Vector expected =
          dense_sum(dense(c.chain, c.acting()), c.chain.initial_state(), 1500, gamma);  // 0.97^1500: 1e-20
      for (double& visits : expected) {
        visits *= 1.0 - gamma;
      }
      const Occupancy* found = exact.discounted(c.acting(), gamma);
      ASSERT_NE(found, nullptr);
      expect_near(by_state(*found, 60), expected, 1e-12);
    }
  }
}

TEST(ExactOccupancy, LongRunIsTheMeanOfThePowersOfADenseMatrix) {
  bool several_classes = false;
  for (const Case& c : random_cases(30, 8)) {
    SCOPED_TRACE(c.name);
    ExactOccupancy exact(c.chain);
    const Occupancy* found = exact.long_run(c.acting());
    ASSERT_NE(found, nullptr);
    expect_near(by_state(*found, 30), dense_long_run(dense(c.chain, c.acting()), c.chain.initial_state()), 1e-8);
    ReachedRows rows(c.chain);
    rows.begin(c.acting());
    rows.expand_all();
    const auto classes = closed_classes(rows);
    int roots = 0;
    for (std::uint32_t k = 0; k < classes.size(); ++k) {
      roots += classes[k] == k ? 1 : 0;
    }
    EXPECT_GE(roots, 1);
    several_classes = several_classes || roots > 1;
  }
  EXPECT_TRUE(several_classes) << "no case ends in one of several classes by chance";
}

TEST(ExactOccupancy, LongRunIsTheLimitOfTheDiscountedOne) {
  for (const Case& c : random_cases(200, 4)) {
    SCOPED_TRACE(c.name);
    ExactOccupancy exact(c.chain);
    const Occupancy* limit = exact.long_run(c.acting());
    ASSERT_NE(limit, nullptr);
    const Vector expected = by_state(*limit, 200);
    const Occupancy* near = exact.discounted(c.acting(), kMaxGamma);
    ASSERT_NE(near, nullptr);
    expect_near(by_state(*near, 200), expected, 2e-3);
  }
}

TEST(ExactOccupancy, AStepAtATimeIsTheSameWhateverWasAskedBefore) {
  const auto cases = random_cases(150, 3);
  ExactOccupancy used(cases[0].chain);
  used.over_steps(cases[0].acting(), 77);
  ASSERT_NE(used.long_run(cases[1].acting()), nullptr);
  ExactOccupancy fresh(cases[0].chain);
  const auto bits = [](const Occupancy& occupancy) { return std::pair(occupancy.states, occupancy.visits); };
  const auto steps = bits(fresh.over_steps(cases[0].acting(), 30));
  EXPECT_EQ(bits(used.over_steps(cases[0].acting(), 30)), steps);
  const auto discounted = bits(*fresh.discounted(cases[0].acting(), 0.9));
  EXPECT_EQ(bits(*used.discounted(cases[0].acting(), 0.9)), discounted);
  const auto long_run = bits(*fresh.long_run(cases[0].acting()));
  EXPECT_EQ(bits(*used.long_run(cases[0].acting())), long_run);
}

TEST(ExactOccupancy, WithoutAnActionAWalkStays) {
  const Chain chain = oracles::random_chain({.states = 20, .actions = 2, .seed = 3});
  const std::vector<std::uint8_t> none(20, 2);
  const ActingTables acting{none, {}, 0.0};
  Vector expected(20, 0.0);
  ExactOccupancy exact(chain);
  expected[chain.initial_state()] = 9.0;
  EXPECT_EQ(by_state(exact.over_steps(acting, 9), 20), expected);
  expected[chain.initial_state()] = 1.0;
  const Occupancy* discounted = exact.discounted(acting, 0.5);
  ASSERT_NE(discounted, nullptr);
  expect_near(by_state(*discounted, 20), expected, 1e-15);
  const Occupancy* long_run = exact.long_run(acting);
  ASSERT_NE(long_run, nullptr);
  expect_near(by_state(*long_run, 20), expected, 1e-15);
}

TEST(ExactOccupancy, OnlyTheStatesThatHaveMassAreTouched) {
  const Chain ruin = oracles::gamblers_ruin({.fortune = 30, .goal = 60, .wins = 1, .losses = 1});
  const std::vector<std::uint8_t> bet(61, 0);
  ExactOccupancy exact(ruin);
  const Occupancy& found = exact.over_steps({bet, {}, 0.0}, 5);
  EXPECT_EQ(found.states.size(), 9U);
  EXPECT_EQ(found.states.front(), 30U);
}

TEST(ClosedFormExactly, KnuthsDieIsFairAndTakesElevenThirdsFlips) {
  const Chain die = oracles::knuth_die();
  const std::vector<std::uint8_t> flip(13, 0);
  ExactOccupancy exact(die);
  const Occupancy* limit = exact.long_run({flip, {}, 0.0});
  ASSERT_NE(limit, nullptr);
  const Vector long_run = by_state(*limit, 13);
  for (std::size_t state = 0; state < 13; ++state) {
    EXPECT_NEAR(long_run[state], state < 7 ? 0.0 : 1.0 / 6.0, 1e-15) << state;
  }
  const Vector visits = by_state(exact.over_steps({flip, {}, 0.0}, 200), 13);  // all but 2^-130 of the walks are over
  EXPECT_NEAR(std::accumulate(visits.begin(), visits.begin() + 7, 0.0), 11.0 / 3.0, 1e-13);
  // Visits of s0 to s6 in closed form: 1, 2/3, 2/3, then half of the state before.
  expect_near({visits.begin(), visits.begin() + 7},
              {1.0, 2.0 / 3.0, 2.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0}, 1e-14);
}

TEST(ClosedFormExactly, TheGamblerIsRuinedAsOftenAsTheFormulaSays) {
  for (const auto& [wins, losses] : {std::pair{9U, 10U}, {10U, 9U}, {1U, 2U}, {1U, 1U}}) {
    const oracles::Gambler gambler{.fortune = 4, .goal = 10, .wins = wins, .losses = losses};
    const Chain chain = oracles::gamblers_ruin(gambler);
    const std::vector<std::uint8_t> bet(11, 0);
    const double r = static_cast<double>(losses) / wins;
    const double expected = wins == losses ? 0.4 : (1 - std::pow(r, 4)) / (1 - std::pow(r, 10));
    ExactOccupancy exact(chain);
    const Occupancy* limit = exact.long_run({bet, {}, 0.0});
    ASSERT_NE(limit, nullptr);
    const Vector long_run = by_state(*limit, 11);
    EXPECT_NEAR(long_run[10], expected, 1e-14) << wins << ":" << losses;
    EXPECT_NEAR(long_run[0], 1 - expected, 1e-14) << wins << ":" << losses;
    // Fair game: the expected number of rounds is fortune x (goal - fortune).
    if (wins == losses) {
      const Vector visits = by_state(exact.over_steps({bet, {}, 0.0}, 3000), 11);
      EXPECT_NEAR(std::accumulate(visits.begin() + 1, visits.begin() + 10, 0.0), 24.0, 1e-11);
    }
  }
}

TEST(ClosedFormExactly, APairNeverTriedLeadsEverywhereAlike) {
  // Two states: 0 was never tried and goes to either alike, 1 goes back to 0 with probability 1/4. Balance:
  // v0 / 2 = v1 / 4, so v = (1/3, 2/3).
  ChainParts parts;
  parts.vocabulary.features = {{"b", {0, 1}, true, false}};
  parts.vocabulary.actions = {"go"};
  parts.features = {0, 1};
  parts.row_begin = {0, 0, 2};
  parts.successor = {0, 1};
  parts.count = {1, 3};
  parts.reward_sum = {0.0, 0.0};
  parts.q = {0.0, 0.0};
  parts.policy = {ActionId{0}, ActionId{0}};
  parts.visits = {1, 1};
  const auto chain = Chain::make(std::move(parts));
  ASSERT_TRUE(chain.has_value()) << chain.error().message;
  const std::vector<std::uint8_t> go(2, 0);
  ExactOccupancy exact(*chain);
  const Occupancy* limit = exact.long_run({go, {}, 0.0});
  ASSERT_NE(limit, nullptr);
  expect_near(by_state(*limit, 2), {1.0 / 3.0, 2.0 / 3.0}, 1e-15);
  expect_near(by_state(exact.over_steps({go, {}, 0.0}, 3), 2), {1.0 + 0.5 + 0.375, 0.5 + 0.625}, 1e-15);
  // (1 - g) (e0 + g v P): v0 = (1 - g) + g (v0 / 2 + v1 / 4), v0 + v1 = 1.
  const double g = 0.8;
  const double v0 = (1 - g + g / 4) / (1 - g / 4);
  const Occupancy* discounted = exact.discounted({go, {}, 0.0}, g);
  ASSERT_NE(discounted, nullptr);
  expect_near(by_state(*discounted, 2), {v0, 1 - v0}, 1e-15);
}

TEST(ClosedFormExactly, ExitsThatAreAlmostNeverTakenAreFoundOrGivenUpNeverWrong) {
  // A corridor in which every step on has probability 1 / count, else back to the start; the end stays.
  for (const std::uint32_t count : {10U, 1000U, 100'000'000U}) {
    ChainParts parts;
    constexpr std::uint32_t kStates = 6;
    parts.vocabulary.actions = {"go"};
    for (std::uint8_t bit = 0; bit < 3; ++bit) {
      parts.vocabulary.features.push_back({std::string(1, static_cast<char>('a' + bit)), {0, 1}, true, false});
    }
    parts.row_begin = {0};
    for (std::uint32_t state = 0; state < kStates; ++state) {
      for (std::uint32_t bit = 0; bit < 3; ++bit) {
        parts.features.push_back(static_cast<std::uint8_t>(state >> bit & 1U));
      }
      if (state + 1 < kStates) {
        parts.successor.insert(parts.successor.end(), {0, state + 1});
        parts.count.insert(parts.count.end(), {count - 1, 1});
      } else {
        parts.successor.push_back(state);
        parts.count.push_back(1);
      }
      parts.row_begin.push_back(parts.successor.size());
    }
    parts.reward_sum.assign(kStates, 0.0);
    parts.q.assign(kStates, 0.0);
    parts.policy.assign(kStates, ActionId{0});
    parts.visits.assign(kStates, 1);
    const auto chain = Chain::make(std::move(parts));
    ASSERT_TRUE(chain.has_value()) << chain.error().message;
    const std::vector<std::uint8_t> go(kStates, 0);
    ExactOccupancy exact(*chain);
    const Occupancy* limit = exact.long_run({go, {}, 0.0});
    EXPECT_TRUE(limit != nullptr || count == 100'000'000U) << count;
    if (limit != nullptr) {
      EXPECT_NEAR(by_state(*limit, kStates)[kStates - 1], 1.0, kSolveTolerance);
    }
  }
}

}  // namespace
}  // namespace coppice
