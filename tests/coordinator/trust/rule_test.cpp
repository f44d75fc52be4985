// Rules as text.
#include "coordinator/trust/rule.hpp"

#include <gtest/gtest.h>

#include "tests/common/tree/arbitrary.hpp"

namespace coppice {
namespace {

bool applies(const Rule& rule, std::initializer_list<std::uint8_t> features) {
  return rule.applies(std::vector<std::uint8_t>(features));
}

void expect_wrong(std::string_view text, std::string_view part) {
  const auto rule = parse_rule(text, arbitrary::uav());
  ASSERT_FALSE(rule) << text;
  EXPECT_EQ(rule.error().kind, ErrorKind::bad_input);
  EXPECT_NE(rule.error().message.find(part), std::string::npos) << rule.error().message;
}

TEST(Rule, SaysWhenItAppliesAndWhatBreaksIt) {
  const auto rule = parse_rule("never move when s3=0", arbitrary::uav());
  ASSERT_TRUE(rule) << rule.error().message;
  EXPECT_FALSE(rule->always);
  EXPECT_TRUE(applies(*rule, {1, 1, 1, 0, 1, 1, 1, 1}));
  EXPECT_FALSE(applies(*rule, {0, 0, 0, 1, 0, 0, 0, 0}));
  EXPECT_TRUE(rule->broken_by(ActionId{0}));
  EXPECT_FALSE(rule->broken_by(ActionId{1}));
  EXPECT_FALSE(rule->broken_by(kNoAction));
}

TEST(Rule, JoinsActionsAndTests) {
  const auto rule =
      parse_rule("always turn_left or turn_right when s3 = 0 and s1!=3 or s7<1 and s7 >= 0", arbitrary::uav());
  ASSERT_TRUE(rule) << rule.error().message;
  EXPECT_TRUE(applies(*rule, {1, 1, 1, 0, 1, 1, 1, 1}));
  EXPECT_FALSE(applies(*rule, {1, 3, 1, 0, 1, 1, 1, 1}));
  EXPECT_TRUE(applies(*rule, {1, 3, 1, 1, 1, 1, 1, 0}));
  EXPECT_TRUE(rule->broken_by(ActionId{0}));
  EXPECT_TRUE(rule->broken_by(kNoAction));
  EXPECT_FALSE(rule->broken_by(ActionId{2}));
}

TEST(Rule, WithoutAConditionIsAboutEverything) {
  const auto rule = parse_rule("never none", arbitrary::uav());
  ASSERT_TRUE(rule);
  EXPECT_TRUE(applies(*rule, {0, 0, 0, 0, 0, 0, 0, 0}));
  EXPECT_TRUE(rule->broken_by(kNoAction));
}

TEST(Rule, MistakesAreNamedWithTheirColumn) {
  expect_wrong("", "column 1: found the end, expected 'never' or 'always'");
  expect_wrong("sometimes move", "column 1");
  expect_wrong("never fly", "column 7: found 'fly', expected an action (move, turn_left, turn_right, or none)");
  expect_wrong("never move if s3=0", "column 12: found 'if', expected 'or', 'when' or the end");
  expect_wrong("never move when", "column 16: found the end, expected a feature");
  expect_wrong("never move when s9=0", "column 17: found 's9'");
  expect_wrong("never move when s3", "column 19: found the end, expected =");
  expect_wrong("never move when s3=2", "column 20: found '2', expected a value of s3 (0, 1, 3)");
  expect_wrong("never move when s3=99999999999999999999", "a value of s3");
  expect_wrong("never move when s3=0 und", "expected 'and', 'or' or the end");
  expect_wrong("never move when s3=0 and", "found the end");
  expect_wrong("never move when s3=0 and s3=1", "no observation meets the tests of s3");
  expect_wrong("never move when s3\x1b=0", "found");
  expect_wrong(std::string(5000, 'x'), "4096");
}

TEST(Rule, NeverThrowsOnAnyText) {
  Xoshiro256 random(3);
  const std::vector<std::string> words{"never", "always", "move", "none", "when", "and", "or", "s3",
                                       "=",     "<=",     "0",    "3",    "!",    " ",   "(",  "\xff"};
  int good = 0;
  for (int i = 0; i < 20'000; ++i) {
    std::string text = random.below(2) == 0 ? "never move " : "";
    for (std::uint64_t n = random.below(8); n > 0; --n) {
      text += words[random.below(words.size())] + (random.below(2) == 0 ? " " : "");
    }
    const auto rule = parse_rule(text, arbitrary::uav());
    good += rule ? 1 : 0;
    if (rule) {
      ASSERT_FALSE(rule->when.empty());
      ASSERT_FALSE(rule->actions.empty());
    }
  }
  EXPECT_GT(good, 100);
}

}  // namespace
}  // namespace coppice
