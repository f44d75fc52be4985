// Proofs against every observation there is.
#include "coordinator/trust/rule_check.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "common/tree/tick.hpp"
#include "coordinator/trust/jumps.hpp"
#include "tests/common/tree/arbitrary.hpp"

namespace coppice {
namespace {

Rule rule_of(std::string_view text, const Vocabulary& vocabulary) {
  const auto rule = parse_rule(text, vocabulary);
  EXPECT_TRUE(rule) << text << ": " << rule.error().message;
  return *rule;
}

// A condition of 0 to 3 tests, at most two of which are joined by "or".
std::string random_rule(Xoshiro256& random, const Vocabulary& vocabulary) {
  const std::vector<std::string> ops{"=", "!=", "<=", "<", ">=", ">"};
  std::string text = random.below(2) == 0 ? "never " : "always ";
  text += random.below(6) == 0 ? "none" : vocabulary.actions[random.below(vocabulary.actions.size())];
  for (std::uint64_t i = 0, n = random.below(4); i < n; ++i) {
    const Feature& feature = vocabulary.features[random.below(vocabulary.features.size())];
    text += i == 0 ? " when " : random.below(3) == 0 ? " or " : " and ";
    text += fmt::format("{}{}{}", feature.name, ops[random.below(ops.size())],
                        feature.values[random.below(feature.values.size())]);
  }
  return text;
}

TEST(RuleCheck, AgreesWithEveryObservationOnRandomTrees) {
  Xoshiro256 random(1);
  const Below below = arbitrary::below_of(random);
  int held = 0;
  int broken = 0;
  for (int i = 0; i < 3000; ++i) {
    const Vocabulary vocabulary = arbitrary::vocabulary(random, 1 + random.below(5), 3, 3);
    const Tree tree = grow_tree(vocabulary, {.max_depth = 1 + random.below(5), .max_children = 4}, true, below);
    const auto rule = parse_rule(random_rule(random, vocabulary), vocabulary);
    if (!rule) {  // no observation meets it
      continue;
    }
    const auto answer = check_rule(*rule, tree, vocabulary);
    ASSERT_TRUE(answer) << answer.error().message;
    const std::vector<Jump> jumps = jumps_of(tree);
    const auto rows = arbitrary::all_observations(vocabulary);
    bool holds = true;
    std::vector<bool> last_word(tree.size(), false);
    for (std::size_t r = 0; r < rows.size() / vocabulary.features.size(); ++r) {
      const auto features = arbitrary::row(rows, vocabulary, r);
      if (!rule->applies(features)) {
        continue;
      }
      holds = holds && !rule->broken_by(tick(tree, features));
      if (const std::size_t writer = last_writer(tree, jumps, features); writer != kTickEnds) {
        last_word[writer] = true;
      }
    }
    const std::string what = rule->text + " of " + to_text(tree, vocabulary);
    ASSERT_EQ(answer->holds(), holds) << what;
    for (std::size_t node = 0; node < tree.size(); ++node) {
      ASSERT_EQ(answer->nodes[node].last_word, last_word[node]) << node << ": " << what;
      ASSERT_TRUE(answer->nodes[node].ticked || !last_word[node]) << what;
    }
    if (!holds) {
      const Counterexample& example = *answer->broken;
      ASSERT_TRUE(rule->applies(example.features)) << what;
      ASSERT_EQ(tick(tree, example.features), example.action) << what;
      ASSERT_TRUE(rule->broken_by(example.action)) << what;
      // What does not matter may be anything.
      std::vector<std::uint8_t> other = example.features;
      for (std::size_t f = 0; f < other.size(); ++f) {
        const auto& values = vocabulary.features[f].values;
        other[f] = example.matters[f] ? other[f] : values[random.below(values.size())];
      }
      ASSERT_TRUE(rule->broken_by(tick(tree, other))) << what;
    }
    (holds ? held : broken) += 1;
  }
  EXPECT_GT(held, 300);
  EXPECT_GT(broken, 300);
}

TEST(RuleCheck, TheThesisArgumentNamesTheNodesThatDecide) {
  const Vocabulary vocabulary = arbitrary::uav();
  const Tree tree = arbitrary::tree("(selector (sequence s3=0 turn_left) (sequence s1=3 turn_left) move)", vocabulary);
  const auto answer = check_rule(rule_of("never move when s3=0", vocabulary), tree, vocabulary);
  ASSERT_TRUE(answer);
  EXPECT_TRUE(answer->holds());
  EXPECT_EQ(answer->ticked(), 4U);  // selector, sequence, s3=0, turn_left
  EXPECT_TRUE(answer->nodes[3].last_word);
  EXPECT_FALSE(answer->nodes[7].ticked);
}

TEST(RuleCheck, FindsTheObservationThatBreaksIt) {
  const Vocabulary vocabulary = arbitrary::uav();
  const Tree tree = arbitrary::tree("(selector (sequence s3=0 s1=1 turn_left) move)", vocabulary);
  const auto answer = check_rule(rule_of("never move when s3=0", vocabulary), tree, vocabulary);
  ASSERT_TRUE(answer && answer->broken);
  EXPECT_EQ(answer->broken->features, (std::vector<std::uint8_t>{0, 0, 0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(answer->broken->matters, (std::vector<bool>{false, true, false, true, false, false, false, false}));
  EXPECT_EQ(answer->broken->writer, 5U);
}

// 2^60 observations, and as many paths: each selector goes on, whichever child succeeds.
TEST(RuleCheck, SixtyFeaturesTakeAFewStatesEach) {
  Vocabulary vocabulary;
  std::string text = "(sequence";
  for (int f = 0; f < 60; ++f) {
    vocabulary.features.push_back({fmt::format("f{}", f), {0, 1}});
    text += fmt::format(" (selector f{}=0 {})", f, f % 2 == 0 ? "a" : "b");
  }
  vocabulary.actions = {"a", "b", "c"};
  const Tree tree = arbitrary::tree(text + ")", vocabulary);
  const auto never = check_rule(rule_of("never c", vocabulary), tree, vocabulary);
  ASSERT_TRUE(never) << never.error().message;
  EXPECT_TRUE(never->holds());
  EXPECT_LT(never->states, 10'000U);
  const auto none = check_rule(rule_of("never none when f7=1", vocabulary), tree, vocabulary);
  ASSERT_TRUE(none);
  EXPECT_TRUE(none->holds());
  const auto some = check_rule(rule_of("never none", vocabulary), tree, vocabulary);
  ASSERT_TRUE(some);
  EXPECT_FALSE(some->holds());
  EXPECT_EQ(some->broken->features, std::vector<std::uint8_t>(60, 0));
}

}  // namespace
}  // namespace coppice
