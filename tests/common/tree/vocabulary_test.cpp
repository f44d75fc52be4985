#include "common/tree/vocabulary.hpp"

#include <gtest/gtest.h>

#include "tests/common/tree/arbitrary.hpp"

namespace coppice {
namespace {

TEST(Vocabulary, of_the_uav_is_well_formed_and_finds_its_names) {
  const Vocabulary uav = arbitrary::uav();
  EXPECT_TRUE(check_vocabulary(uav).has_value());
  EXPECT_EQ(uav.find_feature("s7"), 7U);
  EXPECT_EQ(uav.find_feature("s8"), std::nullopt);
  EXPECT_EQ(uav.find_action("turn_right"), ActionId{2});
  EXPECT_EQ(uav.find_action("s0"), std::nullopt);
}

std::string refusal(const Vocabulary& vocabulary) {
  const Result<void> checked = check_vocabulary(vocabulary);
  return checked ? "accepted" : checked.error().message;
}

TEST(Vocabulary, that_is_malformed_is_refused_with_the_place_and_what_was_expected) {
  Vocabulary none;
  EXPECT_EQ(refusal(none), "0 features: expected 1 to 64");
  Vocabulary reserved = arbitrary::uav();
  reserved.actions[1] = "selector";
  EXPECT_EQ(refusal(reserved), "action name 'selector' is reserved for a tree's composites");
  Vocabulary twice = arbitrary::uav();
  twice.actions[0] = "s3";
  EXPECT_EQ(refusal(twice), "action name 's3' is used twice");
  Vocabulary descending = arbitrary::uav();
  descending.features[2].values = {1, 0};
  EXPECT_EQ(refusal(descending), "feature 's2': expected at least one value, in ascending order");
  Vocabulary mute = arbitrary::uav();
  mute.features[4].admits_equal = false;
  EXPECT_EQ(refusal(mute), "feature 's4' admits no operator: expected = or <= or both");
  Vocabulary blank = arbitrary::uav();
  blank.features[0].name = "s 0";
  EXPECT_NE(refusal(blank).find("feature name is malformed"), std::string::npos);
  Vocabulary many = arbitrary::uav();
  many.actions.assign(kMaxActions + 1, "a");
  EXPECT_EQ(refusal(many), "255 actions: expected 1 to 254");
}

}  // namespace
}  // namespace coppice
