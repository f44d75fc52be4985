#include "coordinator/evolution/pick.hpp"

#include <gtest/gtest.h>
#include <string>

#include "tests/coordinator/evolution/small_world.hpp"

namespace coppice {
namespace {

using testing::tree_of;

const Front kFront{{measure_of(ObjectiveKind::coverage), measure_of(ObjectiveKind::expected_return), kNodesMeasure},
                   {{tree_of("move"), 0.1, {0.5, 10.0, 1}},
                    {tree_of("(sequence a=0 left)"), 0.4, {0.7, 20.0, 3}},
                    {tree_of("(selector (sequence a=0 left) move)"), 0.3, {0.8, 20.0, 5}}}};

std::size_t picked(const char* rule) {
  const auto parsed = parse_pick(rule);
  EXPECT_TRUE(parsed.has_value()) << rule;
  return pick(kFront, *parsed).value_or(99);
}

std::string refused(const char* rule) {
  const auto parsed = parse_pick(rule);
  return parsed ? "accepted" : parsed.error().message;
}

TEST(Pick, GoesOnToWhatIsSaidElse) {
  EXPECT_EQ(picked("best return with coverage>=0.9 else best coverage with nodes<=3"), 1U);
  EXPECT_EQ(picked("best return with coverage>=0.9 else best fitness with nodes<=0 else best coverage"), 2U);
  EXPECT_EQ(picked("best fitness else best coverage"), 1U);
  EXPECT_EQ(picked("best return with coverage>=0.9 else best coverage with nodes<=0"), 99U);
  EXPECT_NE(refused("best fitness else").find("the rule ends"), std::string::npos) << refused("best fitness else");
  EXPECT_NE(refused("best fitness else coverage").find("'coverage': expected a rule"), std::string::npos);
}

TEST(Pick, TakesTheBestOfThoseThatFit) {
  EXPECT_EQ(picked("best fitness"), 1U);
  EXPECT_EQ(picked("best coverage"), 2U);
  EXPECT_EQ(picked("best coverage with nodes<=3"), 1U);
  EXPECT_EQ(picked("best coverage with nodes <= 4 and return >= 15 and fitness>=0"), 1U);
  EXPECT_EQ(picked("best nodes"), 0U) << "a cost: the smallest";
  EXPECT_EQ(picked("best fitness with nodes=5"), 2U);
}

TEST(Pick, TiesGoToTheFitter) { EXPECT_EQ(picked("best return"), 1U); }

TEST(Pick, FindsNothingWhereNothingFitsOrIsMeasured) {
  EXPECT_EQ(picked("best coverage with nodes<=0"), 99U);
  EXPECT_EQ(picked("best agreement"), 99U);
  EXPECT_EQ(picked("best coverage with collisions<=0"), 99U);
}

TEST(Pick, SaysWhatIsWrongWithARule) {
  EXPECT_EQ(refused(""), "the rule ends: expected a rule, such as 'best return with nodes<=20 and coverage>=0.8'");
  EXPECT_EQ(refused("best"), "the rule ends: expected a measure");
  EXPECT_EQ(refused("best return if nodes<=3"), "'if': expected 'with', 'else', or the end");
  EXPECT_EQ(refused("best return with nodes<3"), "'<': expected <=, >= or =");
  EXPECT_EQ(refused("best return with nodes<=three"), "'three': expected a number");
  EXPECT_EQ(refused("best return with nodes<=nan"), "'nan': expected a number");
  EXPECT_EQ(refused("best return with nodes<=3 with"), "'with': expected 'and', 'else', or the end");
  EXPECT_EQ(refused("best size").rfind("no measure 'size': expected one of agreement, ", 0), 0U);
}

}  // namespace
}  // namespace coppice
