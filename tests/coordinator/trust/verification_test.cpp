// Figures with their intervals, where both are known.
#include "coordinator/trust/verification.hpp"

#include <cmath>
#include <gtest/gtest.h>

#include "common/tree/text.hpp"
#include "coordinator/trust/verification_report.hpp"
#include "tests/oracles/chains.hpp"

namespace coppice {
namespace {

// From state 0 `go` leads to state 1 (reward 5 there) or state 2 (reward 0 there); both lead back to 0. `stay` was
// never tried anywhere.
Chain fork(std::uint32_t to_one, std::uint32_t to_two) {
  ChainParts parts;
  parts.vocabulary.features = {{"f", {0, 1, 2}}};
  parts.vocabulary.actions = {"go", "stay"};
  parts.features = {0, 1, 2};
  parts.row_begin = {0, 2, 2, 3, 3, 4, 4};
  parts.successor = {1, 2, 0, 0};
  parts.count = {to_one, to_two, 1000, 1000};
  parts.reward_sum = {0.0, 0.0, 5000.0, 0.0, 0.0, 0.0};
  parts.q = std::vector<double>(6, 0.0);
  parts.policy.assign(3, ActionId{0});
  parts.visits = {to_one + to_two, 1000, 1000};
  return *Chain::make(std::move(parts));
}

Tree tree_of(std::string_view text, const Chain& chain) { return *parse_tree(text, chain.vocabulary()); }

TEST(Verify, AnIntervalIsThatOfTheCounts) {
  const Chain chain = fork(30, 70);
  VerifySettings settings;
  settings.steps = 2;
  settings.resamples = 4000;
  const auto found =
      verify(chain, tree_of("go", chain), {{.name = "five", .at_most = false, .bound = 5.0}}, {}, settings, {});
  ASSERT_TRUE(found) << found.error().message;
  const Figure& within = found->events[0].within;
  EXPECT_DOUBLE_EQ(within.value, 0.3);
  // Beta(30, 70): mean 0.3, standard deviation sqrt(0.3 * 0.7 / 101) = 0.0456; its quantiles, by R's qbeta.
  EXPECT_NEAR(within.low, 0.2149, 0.006);
  EXPECT_NEAR(within.high, 0.3930, 0.006);
  EXPECT_DOUBLE_EQ(found->reward.value, 1.5);
  EXPECT_NEAR(found->reward.low, 5.0 * within.low, 1e-9);
  ASSERT_TRUE(found->reward_per_step);
  EXPECT_NEAR(found->reward_per_step->value, 0.75, 1e-12);
  ASSERT_TRUE(found->events[0].ever && found->events[0].steps);
  EXPECT_EQ(found->events[0].ever->value, 1.0);
  // Two steps a round, 1 / 0.3 rounds on average.
  EXPECT_NEAR(found->events[0].steps->value, 2.0 / 0.3, 1e-9);
  EXPECT_EQ(found->untried.within.high, 0.0);
}

TEST(Verify, MoreCountsANarrowerInterval) {
  const auto width = [](std::uint32_t factor) {
    const Chain chain = fork(3 * factor, 7 * factor);
    VerifySettings settings;
    settings.steps = 2;
    const auto found =
        verify(chain, tree_of("go", chain), {{.name = "five", .at_most = false, .bound = 5.0}}, {}, settings, {});
    return found->events[0].within.high - found->events[0].within.low;
  };
  EXPECT_NEAR(width(10) / width(1000), 10.0, 3.0);  // as the square root of the counts
}

TEST(Verify, AnActionNeverTriedLeavesTheModel) {
  const Chain chain = fork(30, 70);
  VerifySettings settings;
  settings.steps = 2;
  const auto found = verify(chain, tree_of("(selector (sequence f=1 stay) go)", chain),
                            {{.name = "five", .at_most = false, .bound = 5.0}}, {}, settings, {});
  ASSERT_TRUE(found);
  EXPECT_DOUBLE_EQ(found->untried.within.value, 0.3);
  EXPECT_EQ(found->untried.ever->value, 1.0);
  EXPECT_EQ(found->events[0].ever->value, 0.0) << "what comes after leaving does not count";
  EXPECT_FALSE(found->events[0].steps);
}

TEST(Verify, NeverSeenSuccessorsAreEstimatedFromThoseSeenOnce) {
  const Chain chain = fork(1, 9);
  VerifySettings settings;
  settings.steps = 1;
  settings.resamples = 2000;
  const auto found = verify(chain, tree_of("go", chain), {}, {}, settings, {});
  ASSERT_TRUE(found);
  EXPECT_DOUBLE_EQ(found->unseen.within.value, 0.1);
  EXPECT_EQ(found->untried.within.value, 0.0);
  // Beta(1, 9): P(x <= q) = 1 - (1 - q)^9.
  EXPECT_NEAR(found->unseen.within.low, 1.0 - std::pow(0.975, 1.0 / 9.0), 0.002);
  EXPECT_NEAR(found->unseen.within.high, 1.0 - std::pow(0.025, 1.0 / 9.0), 0.03);
}

TEST(Verify, SaysThatIntervalsAreTooNarrowWhereMuchWasNeverSeen) {
  VerifySettings settings;
  settings.steps = 4;
  const auto found = [&](std::uint32_t once, std::uint32_t often) {
    const Chain chain = fork(once, often);
    return *verify(chain, tree_of("go", chain), {}, {}, settings, {});
  };
  const Verification few = found(1, 9);  // two chances in four steps, 0.1 each, to come to what was not seen
  EXPECT_GT(few.unseen.within.value, kTooOftenUnseen);
  EXPECT_TRUE(few.intervals_too_narrow());
  EXPECT_NE(to_text(few, {}).find("The intervals are too narrow: 19.00 %"), std::string::npos) << to_text(few, {});
  EXPECT_EQ(to_json(few, {})["intervals_too_narrow"], true);
  const Verification many = found(30, 70);
  EXPECT_FALSE(many.intervals_too_narrow());
  EXPECT_EQ(to_text(many, {}).find("too narrow"), std::string::npos);
  EXPECT_EQ(to_json(many, {})["intervals_too_narrow"], false);
}

TEST(Verify, TheSameSeedGivesTheSameIntervals) {
  const Chain chain = oracles::random_chain({.states = 80, .actions = 3, .seed = 4});
  const Tree tree = tree_of("(selector (sequence f0=0 a1) a0)", chain);
  const auto once = [&] { return verify(chain, tree, {}, {}, {}, {}); };
  EXPECT_EQ(once()->reward.low, once()->reward.low);
  VerifySettings other;
  other.seed = 2;
  EXPECT_NE(once()->reward.low, verify(chain, tree, {}, {}, other, {})->reward.low);
}

TEST(Verify, AProbabilityIsAtMostOneAndLiesInItsInterval) {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    const Chain chain = oracles::random_chain({.states = 60, .actions = 3, .seed = seed});
    const Tree tree = tree_of("(selector (sequence f0=0 a1) a0)", chain);
    VerifySettings settings;
    settings.resamples = kFewestResamples;
    settings.seed = seed;
    const std::vector<Event> events = {{.name = "some", .at_most = false, .bound = 0.0},
                                       {.name = "any", .at_most = false, .bound = -1e9}};
    const auto found = verify(chain, tree, events, {}, settings, {});
    ASSERT_TRUE(found) << found.error().message;
    const auto check = [&](const std::optional<Figure>& figure, bool is_probability) {
      if (!figure) {
        return;
      }
      EXPECT_LE(figure->low, figure->value) << seed;
      EXPECT_GE(figure->high, figure->value) << seed;
      if (is_probability) {
        EXPECT_GE(figure->low, 0.0) << seed;
        EXPECT_LE(figure->high, 1.0) << seed;
      }
    };
    check(found->reward, false);
    check(found->reward_per_step, false);
    std::vector<EventFigures> all = found->events;
    all.push_back(found->untried);
    all.push_back(found->unseen);
    for (const EventFigures& event : all) {
      check(event.within, true);
      check(event.ever, true);
      check(event.steps, false);
    }
  }
}

TEST(Verify, SaysThatEverMeansLittleWhereTheWalkLeavesTheModel) {
  const Chain chain = fork(30, 70);
  VerifySettings settings;
  settings.steps = 2;
  const std::vector<Event> five = {{.name = "five", .at_most = false, .bound = 5.0}};
  const std::string leaving =
      to_text(*verify(chain, tree_of("(selector (sequence f=1 stay) go)", chain), five, {}, settings, {}), {});
  EXPECT_NE(leaving.find("five ever, before it leaves the model"), std::string::npos) << leaving;
  EXPECT_NE(leaving.find("\"ever\" says little here: 100 %"), std::string::npos) << leaving;
  const std::string staying = to_text(*verify(chain, tree_of("go", chain), five, {}, settings, {}), {});
  EXPECT_EQ(staying.find("says little"), std::string::npos) << staying;
  EXPECT_EQ(staying.find("before it leaves"), std::string::npos) << staying;
}

TEST(Verify, CanBeInterrupted) {
  const Chain chain = fork(3, 7);
  const auto found = verify(chain, tree_of("go", chain), {}, {}, {}, [](std::uint32_t done) { return done < 30; });
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().kind, ErrorKind::interrupted);
}

TEST(Wilson, IsTheIntervalOfWilson) {
  // Newcombe, Statistics in Medicine 1998, table I: 81 of 263, 15 of 148, 0 of 20, 1 of 29.
  const auto expect = [](std::uint64_t successes, std::uint64_t trials, double low, double high) {
    const Figure found = wilson(successes, trials);
    EXPECT_NEAR(found.low, low, 1e-4);
    EXPECT_NEAR(found.high, high, 1e-4);
  };
  expect(81, 263, 0.2553, 0.3662);
  expect(15, 148, 0.0624, 0.1605);
  expect(0, 20, 0.0, 0.1611);
  expect(1, 29, 0.0061, 0.1718);
}

}  // namespace
}  // namespace coppice
