// What a chain of a problem has beyond counts: several starts, ends of episodes, actions that a state lacks, what
// happens when nothing is chosen. Held against plain sums.
#include <algorithm>
#include <array>
#include <gtest/gtest.h>

#include "common/chain/alias_rows.hpp"
#include "common/chain/chain_bytes.hpp"
#include "common/chain/exact.hpp"
#include "common/chain/exact_events.hpp"
#include "common/chain/lazy_row.hpp"
#include "tests/oracles/chains.hpp"

namespace coppice {
namespace {

constexpr std::uint8_t kActionCount = 3;

ChainParts plain_parts(std::uint64_t seed) {
  return oracles::random_chain({.states = 60, .actions = kActionCount, .seed = seed}).parts();
}

// Empties a row.
void forbid(ChainParts& parts, std::size_t row) {
  const std::uint64_t begin = parts.row_begin[row];
  const std::uint64_t size = parts.row_begin[row + 1] - begin;
  const auto at = static_cast<std::ptrdiff_t>(begin);
  parts.successor.erase(parts.successor.begin() + at, parts.successor.begin() + at + static_cast<std::ptrdiff_t>(size));
  parts.count.erase(parts.count.begin() + at, parts.count.begin() + at + static_cast<std::ptrdiff_t>(size));
  for (std::size_t later = row + 1; later < parts.row_begin.size(); ++later) {
    parts.row_begin[later] -= size;
  }
  parts.reward_sum[row] = 0.0;
  parts.forbidden[row] = 1;
}

// With starts in three states, some pairs forbidden, and the given rule.
Chain with_problem(std::uint64_t seed, NoAction rule) {
  ChainParts parts = plain_parts(seed);
  parts.initial_state = 3;
  parts.starts = {{3, 1}, {17, 5}, {40, 2}};
  parts.no_action = rule;
  parts.forbidden.assign(60 * kActionCount, 0);
  for (std::size_t state = 0; state < 60; state += 4) {
    const std::size_t action = (index_of(parts.policy[state]) + 1) % kActionCount;
    forbid(parts, state * kActionCount + action);
  }
  auto chain = Chain::make(std::move(parts));
  EXPECT_TRUE(chain.has_value()) << (chain ? "" : chain.error().message);
  return std::move(*chain);
}

constexpr NoAction kHold{NoAction::Kind::hold, ActionId{0}};
constexpr NoAction kWorst{NoAction::Kind::worst, ActionId{0}};
constexpr NoAction kNamed{NoAction::Kind::named, ActionId{1}};
constexpr std::array kRules{kHold, kWorst, kNamed};

// Where a step leads, as probabilities. [states]
std::vector<double> step_of(const Chain& chain, std::size_t state, std::size_t chosen) {
  std::vector<double> to(chain.states(), 0.0);
  const std::size_t taken = chain.taken(state, chosen);
  if (taken == chain.actions()) {
    to[state] = 1.0;
    return to;
  }
  const std::size_t row = state * chain.actions() + taken;
  if (chain.tries(row) == 0) {
    std::fill(to.begin(), to.end(), 1.0 / static_cast<double>(chain.states()));
    return to;
  }
  for (std::size_t i = 0; i < chain.successors(row).size(); ++i) {
    to[chain.successors(row)[i]] += static_cast<double>(chain.counts(row)[i]) / static_cast<double>(chain.tries(row));
  }
  return to;
}

std::vector<double> starting(const Chain& chain) {
  std::vector<double> now(chain.states(), 0.0);
  for (const StartShare& start : chain.starts()) {
    now[start.state] += static_cast<double>(start.count) / static_cast<double>(chain.starts_total());
  }
  return now;
}

std::vector<std::uint8_t> some_actions(const Chain& chain, std::uint64_t seed) {
  Xoshiro256 random(seed);
  std::vector<std::uint8_t> actions(chain.states());
  for (std::uint8_t& action : actions) {
    action = static_cast<std::uint8_t>(random.below(kActionCount + 1));
  }
  return actions;
}

TEST(ProblemChain, NoActionAndForbiddenOnesAreWhatTheRuleSays) {
  for (const NoAction& rule : kRules) {
    const Chain chain = with_problem(1, rule);
    for (std::size_t state = 0; state < chain.states(); ++state) {
      const std::size_t none = chain.taken(state, chain.actions());
      for (std::size_t action = 0; action < chain.actions(); ++action) {
        EXPECT_EQ(chain.taken(state, action), chain.is_forbidden(state, action) ? none : action);
      }
      switch (rule.kind) {
        case NoAction::Kind::hold:
          EXPECT_EQ(none, chain.actions());
          break;
        case NoAction::Kind::named:
          if (!chain.is_forbidden(state, 1)) {
            EXPECT_EQ(none, 1U);
            break;
          }
          [[fallthrough]];
        case NoAction::Kind::worst:
          for (std::size_t action = 0; action < chain.actions(); ++action) {
            if (chain.tries(state * chain.actions() + action) > 0) {
              ASSERT_LT(none, chain.actions());
              EXPECT_LE(chain.parts().q[state * chain.actions() + none],
                        chain.parts().q[state * chain.actions() + action]);
            }
          }
          break;
      }
    }
  }
}

TEST(ProblemChain, SampledRowsAreThoseOfWhatTakesPlaceInBothForms) {
  for (const NoAction& rule : kRules) {
    const Chain chain = with_problem(2, rule);
    const AliasRows rows(chain);
    LazyRow lazy;
    for (std::size_t state = 0; state < chain.states(); ++state) {
      for (std::size_t chosen = 0; chosen <= chain.actions(); ++chosen) {
        std::vector<std::uint32_t> seen(chain.states(), 0);
        constexpr std::uint32_t kProblemDraws = 256;
        for (std::uint32_t i = 0; i < kProblemDraws; ++i) {
          const std::uint32_t x = i << 24U;
          const auto more = [i](std::uint32_t attempt) { return std::uint64_t{i} * 977 + attempt; };
          const std::uint32_t next = rows.sample(rows.row(state, chosen), x, more);
          EXPECT_EQ(next, lazy.sample(chain, static_cast<std::uint32_t>(state), chosen, x, more));
          ++seen[next];
        }
        const std::vector<double> expected = step_of(chain, state, chosen);
        for (std::size_t next = 0; next < chain.states(); ++next) {
          // Each of a row's bins owns its part of the draws but for one draw at each of its two inner borders.
          EXPECT_NEAR(seen[next], expected[next] * kProblemDraws, 2.0 * 13) << state << " " << chosen << " " << next;
        }
      }
    }
  }
}

TEST(ProblemChain, ExactOccupancyStartsInSharesAndGoesByTheRule) {
  for (const NoAction& rule : kRules) {
    const Chain chain = with_problem(3, rule);
    const std::vector<std::uint8_t> actions = some_actions(chain, 4);
    const ActingTables acting{.actions = actions, .others = {}, .others_share = 0.0};
    constexpr double kGamma = 0.9;
    std::vector<double> over_steps(chain.states(), 0.0);
    std::vector<double> discounted(chain.states(), 0.0);
    std::vector<double> now = starting(chain);
    double weight = 1.0 - kGamma;
    for (int step = 0; step < 400; ++step, weight *= kGamma) {
      std::vector<double> next(chain.states(), 0.0);
      for (std::size_t state = 0; state < chain.states(); ++state) {
        over_steps[state] += step < 25 ? now[state] : 0.0;
        discounted[state] += weight * now[state];
        const std::vector<double> to = step_of(chain, state, actions[state]);
        for (std::size_t successor = 0; successor < to.size(); ++successor) {
          next[successor] += now[state] * to[successor];
        }
      }
      now.swap(next);
    }
    const auto expect_near = [&](const Occupancy& found, const std::vector<double>& expected) {
      std::vector<double> visits(chain.states(), 0.0);
      for (std::size_t i = 0; i < found.states.size(); ++i) {
        visits[found.states[i]] = found.visits[i];
      }
      for (std::size_t state = 0; state < visits.size(); ++state) {
        EXPECT_NEAR(visits[state], expected[state], 1e-10) << state;
      }
    };
    ExactOccupancy exact(chain);
    expect_near(exact.over_steps(acting, 25), over_steps);
    const Occupancy* solved = exact.discounted(acting, kGamma);
    ASSERT_NE(solved, nullptr);
    expect_near(*solved, discounted);
  }
}

// Gambler's ruins from several fortunes at once are the mean of the single ones.
TEST(ProblemChain, EventsAndLongRunsFromSeveralStartsAreTheMeanOfTheirOwn) {
  constexpr std::array<std::uint32_t, 3> kFortunes{0, 4, 7};
  constexpr std::array<std::uint32_t, 3> kShares{1, 2, 5};
  double reached = 0.0;
  std::vector<double> long_run(11, 0.0);
  ChainParts parts;
  for (std::size_t i = 0; i < kFortunes.size(); ++i) {
    const Chain one = oracles::gamblers_ruin({.fortune = kFortunes[i]});
    parts = one.parts();
    const std::vector<std::uint8_t> bet(one.states(), 0);
    std::vector<double> goal(one.states(), 0.0);
    goal[10] = 1.0;
    ExactEvents events(one);
    events.begin({.actions = bet, .others = {}, .others_share = 0.0});
    reached += kShares[i] / 8.0 * events.ever(goal)->probability;
    ExactOccupancy exact(one);
    const Occupancy* occupancy = exact.long_run({.actions = bet, .others = {}, .others_share = 0.0});
    for (std::size_t k = 0; k < occupancy->states.size(); ++k) {
      long_run[occupancy->states[k]] += kShares[i] / 8.0 * occupancy->visits[k];
    }
  }
  parts.initial_state = kFortunes[0];
  for (std::size_t i = 0; i < kFortunes.size(); ++i) {
    parts.starts.push_back({kFortunes[i], kShares[i]});
  }
  const auto chain = Chain::make(std::move(parts));
  ASSERT_TRUE(chain.has_value()) << chain.error().message;
  const std::vector<std::uint8_t> bet(chain->states(), 0);
  const ActingTables acting{.actions = bet, .others = {}, .others_share = 0.0};
  std::vector<double> goal(chain->states(), 0.0);
  goal[10] = 1.0;
  ExactEvents events(*chain);
  events.begin(acting);
  EXPECT_NEAR(events.ever(goal)->probability, reached, 1e-12);
  EXPECT_NEAR(events.within(goal, 100'000), reached, 1e-12);
  ExactOccupancy exact(*chain);
  const Occupancy* occupancy = exact.long_run(acting);
  ASSERT_NE(occupancy, nullptr);
  std::vector<double> found(chain->states(), 0.0);
  for (std::size_t k = 0; k < occupancy->states.size(); ++k) {
    found[occupancy->states[k]] = occupancy->visits[k];
  }
  for (std::size_t state = 0; state < found.size(); ++state) {
    EXPECT_NEAR(found[state], long_run[state], 1e-12) << state;
  }
}

// All that a chain can have.
ChainParts full_parts() {
  ChainParts parts = with_problem(5, kNamed).parts();
  parts.vocabulary.features[0].scale = Scale::numbers;
  parts.vocabulary.features[0].numbers = {-1.5, 0.0, 1e100};
  parts.vocabulary.features[5].scale = Scale::bins;
  parts.vocabulary.features[5].admits_equal = false;
  parts.vocabulary.features[5].numbers = {-0.0419, 0.1};
  parts.look_alikes = true;
  std::copy_n(parts.features.begin(), 6, parts.features.begin() + 6);
  parts.collisions.assign(60 * kActionCount, 0);
  for (std::size_t row = 0; row < parts.collisions.size(); ++row) {
    parts.collisions[row] = parts.row_begin[row + 1] > parts.row_begin[row] ? 1 : 0;
  }
  return parts;
}

void make_terminal(ChainParts& parts) {
  std::vector<std::uint64_t> begin{0};
  std::vector<std::uint32_t> successor;
  std::vector<std::uint32_t> count;
  for (std::size_t row = 0; row < 60 * kActionCount; ++row) {
    if (row / kActionCount == 7) {
      successor.push_back(7);
      count.push_back(1);
      parts.reward_sum[row] = 0.0;
      parts.forbidden[row] = 0;
      parts.collisions[row] = 0;
    } else {
      for (std::uint64_t i = parts.row_begin[row]; i < parts.row_begin[row + 1]; ++i) {
        successor.push_back(parts.successor[i]);
        count.push_back(parts.count[i]);
      }
    }
    begin.push_back(successor.size());
  }
  parts.row_begin = begin;
  parts.successor = successor;
  parts.count = count;
  parts.terminals = {7};
}

TEST(ProblemChain, BytesKeepAllThatAChainCanHaveAndPlainChainsKeepTheirOldOnes) {
  ChainParts parts = full_parts();
  make_terminal(parts);
  const auto chain = Chain::make(parts);
  ASSERT_TRUE(chain.has_value()) << chain.error().message;
  EXPECT_TRUE(chain->is_terminal(7));
  const std::vector<std::uint8_t> bytes = to_bytes(*chain);
  EXPECT_EQ(bytes[4], 2);
  const auto read = chain_from_bytes(bytes);
  ASSERT_TRUE(read.has_value()) << read.error().message;
  EXPECT_EQ(read->parts(), parts);
  for (std::size_t size = 0; size < bytes.size(); size += 1 + size / 50) {
    EXPECT_FALSE(chain_from_bytes(std::span(bytes).first(size)).has_value());
  }
  const Chain plain = oracles::random_chain({.states = 60, .actions = kActionCount, .seed = 5});
  std::vector<std::uint8_t> old = to_bytes(plain);
  EXPECT_EQ(old[4], 1);
  // The hash that the program before problems gave this chain.
  EXPECT_EQ(hash_of(old).hex(), "b4e19c3fe6423ad1af31baf7617da9a2");
  old[4] = 2;
  EXPECT_FALSE(chain_from_bytes(old).has_value());
}

void expect_chain_refused(const ChainParts& parts, const std::string& text) {
  const auto chain = Chain::make(parts);
  ASSERT_FALSE(chain.has_value()) << "expected: " << text;
  EXPECT_NE(chain.error().message.find(text), std::string::npos) << chain.error().message;
}

TEST(ProblemChain, RefusesEveryBrokenPart) {
  ChainParts good = full_parts();
  make_terminal(good);
  ChainParts parts = good;
  parts.starts[1].count = 0;
  expect_chain_refused(parts, "start 1 is state 17 with count 0");
  parts = good;
  std::swap(parts.starts[1], parts.starts[2]);
  expect_chain_refused(parts, "starts are not ascending at 2");
  parts = good;
  parts.starts.resize(1);
  expect_chain_refused(parts, "1 starts");
  parts = good;
  parts.initial_state = 17;
  expect_chain_refused(parts, "beginning with the initial state 17");
  parts = good;
  parts.starts[0].count = parts.starts[1].count = UINT32_MAX;
  expect_chain_refused(parts, "below 2^32");
  parts = good;
  parts.no_action = {NoAction::Kind::named, ActionId{3}};
  expect_chain_refused(parts, "no action is kind 2, action 3");
  parts = good;
  parts.terminals = {60};
  expect_chain_refused(parts, "terminal 0 is state 60");
  parts = good;
  parts.terminals = {7, 8};
  expect_chain_refused(parts, "state 8 ends episodes");
  parts = good;
  parts.forbidden[7] = 2;
  expect_chain_refused(parts, "forbidden is 2");
  parts = good;
  parts.forbidden[7 * kActionCount] = 1;
  expect_chain_refused(parts, "is forbidden and was tried 1 times");
  parts = good;
  parts.collisions[7 * kActionCount] = 2;
  expect_chain_refused(parts, "has 2 collisions in 1 tries");
  parts = good;
  parts.collisions.pop_back();
  expect_chain_refused(parts, "collisions has 179 entries: expected 180");
  parts = good;
  parts.look_alikes = false;
  expect_chain_refused(parts, "have the same features");
  parts = good;
  const auto barred = std::find(parts.forbidden.begin(), parts.forbidden.end(), 1) - parts.forbidden.begin();
  parts.policy[static_cast<std::size_t>(barred) / kActionCount] =
      ActionId{static_cast<std::uint8_t>(static_cast<std::size_t>(barred) % kActionCount)};
  expect_chain_refused(parts, "which is forbidden there");
}

}  // namespace
}  // namespace coppice
