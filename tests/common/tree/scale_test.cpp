// Features whose values stand for numbers: written and read in their own unit.
#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "common/tree/text.hpp"
#include "common/tree/tick.hpp"
#include "common/tree/vocabulary.hpp"

namespace coppice {
namespace {

Feature angle() {
  return {.name = "angle",
          .values = {0, 1, 2},
          .admits_equal = false,
          .admits_less_equal = true,
          .scale = Scale::bins,
          .numbers = {-0.0419, 1e-7}};
}
Feature level() {
  return {.name = "level",
          .values = {0, 1, 2},
          .admits_equal = true,
          .admits_less_equal = true,
          .scale = Scale::numbers,
          .numbers = {-7.0, 0.5, 1000.0}};
}
Vocabulary vocabulary() { return {{angle(), level()}, {"left", "right"}}; }

std::string test_of_edge(const Feature& feature, std::size_t edge) {
  return "(sequence " + feature.name + "<=" + feature.number_text(feature.values[edge]) + " left)";
}

TEST(Scale, TreesAreWrittenInTheFeaturesOwnUnitAndReadBack) {
  const std::string text =
      "(selector (sequence angle<=-0.0419 level=0.5 left) (sequence level<=-7 angle<=1e-07 right) "
      "(sequence angle<=inf level=1000 left))";
  const auto tree = parse_tree(text, vocabulary());
  ASSERT_TRUE(tree.has_value()) << tree.error().message;
  EXPECT_EQ(to_text(*tree, vocabulary()), text);
  EXPECT_EQ((*tree)[2], Node::condition(0, Op::less_equal, 0));
  EXPECT_EQ((*tree)[3], Node::condition(1, Op::equal, 1));
  EXPECT_EQ(parse_tree("(sequence level=0.50 left)", vocabulary())->nodes()[1], Node::condition(1, Op::equal, 1));
}

TEST(Scale, WhatTheFeatureDoesNotReadIsRefusedWithWhatItDoes) {
  for (const std::string text : {"level=2", "level=", "level=0.5x", "level=nan", "level=inf", "level<=1e"}) {
    const auto tree = parse_tree(text, vocabulary());
    ASSERT_FALSE(tree.has_value()) << text;
    EXPECT_NE(tree.error().message.find("one of -7, 0.5, 1000"), std::string::npos) << tree.error().message;
  }
  EXPECT_NE(parse_tree("angle=1e-07", vocabulary()).error().message.find("'<=' after feature 'angle'"),
            std::string::npos);
}

TEST(Scale, AReadingFallsIntoTheBinWhoseConditionsHoldForIt) {
  const Vocabulary words = vocabulary();
  const double least = std::numeric_limits<double>::lowest();
  for (const double reading : {least, -0.05, -0.0419, std::nextafter(-0.0419, 1.0), 0.0, 1e-7, 2e-7, 1e300,
                               std::numeric_limits<double>::infinity()}) {
    const auto value = words.features[0].value_of(reading);
    ASSERT_TRUE(value.has_value());
    for (std::size_t edge = 0; edge < words.features[0].numbers.size(); ++edge) {
      const auto tree = parse_tree(test_of_edge(words.features[0], edge), words);
      ASSERT_TRUE(tree.has_value()) << tree.error().message;
      const std::vector<std::uint8_t> features{*value, 0};
      EXPECT_EQ(tick(*tree, features) == ActionId{0}, reading <= words.features[0].numbers[edge]) << reading;
    }
  }
  EXPECT_FALSE(words.features[0].value_of(std::nan("")).has_value());
  EXPECT_EQ(words.features[1].value_of(0.5), 1);
  EXPECT_FALSE(words.features[1].value_of(0.6).has_value());
}

TEST(Scale, PlainValuesAreCodesOnly) {
  const Feature plain{.name = "s", .values = {0, 1, 3}};
  EXPECT_EQ(plain.value_of(3.0), 3);
  for (const double reading : {2.0, -1.0, 256.0, 0.5, 1e300, std::nan("")}) {
    EXPECT_FALSE(plain.value_of(reading).has_value()) << reading;
  }
  EXPECT_EQ(plain.reading_text(3), "s=3");
  EXPECT_EQ(level().reading_text(0), "level=-7");
  EXPECT_EQ(angle().reading_text(0), "angle in (-inf, -0.0419]");
  EXPECT_EQ(angle().reading_text(1), "angle in (-0.0419, 1e-07]");
  EXPECT_EQ(angle().reading_text(2), "angle in (1e-07, inf)");
}

TEST(Scale, AVocabularyWhoseNumbersDoNotFitIsRefused) {
  const auto refused = [](Feature feature, const std::string& text) {
    const auto ok = check_vocabulary({{std::move(feature)}, {"go"}});
    ASSERT_FALSE(ok.has_value()) << text;
    EXPECT_NE(ok.error().message.find(text), std::string::npos) << ok.error().message;
  };
  Feature feature = angle();
  feature.numbers.push_back(3.0);
  refused(feature, "has 3 numbers for 3 values: expected 2");
  feature = angle();
  feature.numbers[1] = feature.numbers[0];
  refused(feature, "number 1 is -0.0419: expected finite numbers in ascending order");
  feature = angle();
  feature.numbers[0] = std::nan("");
  refused(feature, "expected finite numbers");
  feature = angle();
  feature.admits_equal = true;
  refused(feature, "has bins and admits '='");
  feature = level();
  feature.numbers.clear();
  refused(feature, "has 0 numbers for 3 values: expected 3");
  feature = level();
  feature.scale = Scale::plain;
  refused(feature, "expected 0");
}

}  // namespace
}  // namespace coppice
