// Changes to a tree as text.
#include "coordinator/trust/edit.hpp"

#include <gtest/gtest.h>

#include "tests/common/tree/arbitrary.hpp"

namespace coppice {
namespace {

using Kind = TreeEdit::Kind;

const Vocabulary kUav = arbitrary::uav();
// 0 selector, 1 sequence, 2 s3=0, 3 turn_left, 4 move
const Tree kTree = arbitrary::tree("(selector (sequence s3=0 turn_left) move)", kUav);

TreeEdit edit(Kind kind, std::string_view text) {
  const auto parsed = parse_edit(kind, text, kUav);
  EXPECT_TRUE(parsed) << text << ": " << parsed.error().message;
  return *parsed;
}

std::string edited(const std::vector<TreeEdit>& edits) {
  const auto result = apply_edits(kTree, edits);
  return result ? to_text(*result, kUav) : result.error().message;
}

TEST(Edit, ReplacesInsertsAndDeletes) {
  EXPECT_EQ(edited({}), to_text(kTree, kUav));
  EXPECT_EQ(edited({edit(Kind::replace, "2 s1=3")}), "(selector (sequence s1=3 turn_left) move)");
  EXPECT_EQ(edited({edit(Kind::replace, "0 move")}), "move");
  EXPECT_EQ(edited({edit(Kind::insert, "0 0 (sequence s5=3 turn_right)")}),
            "(selector (sequence s5=3 turn_right) (sequence s3=0 turn_left) move)");
  EXPECT_EQ(edited({edit(Kind::insert, "1 2 s1=1")}), "(selector (sequence s3=0 turn_left s1=1) move)");
  EXPECT_EQ(edited({edit(Kind::remove, "1")}), "(selector move)");
}

TEST(Edit, AllNumbersAreThoseOfTheTreeBefore) {
  const std::vector<TreeEdit> edits{edit(Kind::insert, "0 0 turn_right"), edit(Kind::remove, "4"),
                                    edit(Kind::replace, "2 (selector s3=0 s2=0)"), edit(Kind::insert, "0 0 s0=1")};
  EXPECT_EQ(edited(edits), "(selector turn_right s0=1 (sequence (selector s3=0 s2=0) turn_left))");
}

TEST(Edit, MistakesSayWhatWasExpected) {
  const auto expect = [](const std::vector<TreeEdit>& edits, std::string_view part) {
    const auto result = apply_edits(kTree, edits);
    ASSERT_FALSE(result);
    EXPECT_NE(result.error().message.find(part), std::string::npos) << result.error().message;
  };
  expect({edit(Kind::remove, "5")}, "no node 5: expected 0 to 4");
  expect({edit(Kind::remove, "0")}, "whole tree");
  expect({edit(Kind::insert, "2 0 move")}, "leaf");
  expect({edit(Kind::insert, "0 3 move")}, "position of 0 to 2, found 3");
  expect({edit(Kind::remove, "2"), edit(Kind::remove, "3")}, "node 1 would be left without children");
  expect({edit(Kind::remove, "1"), edit(Kind::replace, "2 s1=1")}, "lies within node 1");
  expect({edit(Kind::remove, "1"), edit(Kind::insert, "1 0 s1=1")}, "lies within node 1");
  expect({edit(Kind::remove, "2"), edit(Kind::replace, "2 s1=1")}, "twice");
  for (const char* text : {"", "x", "-1", "1 2", "99999999999999999999"}) {
    EXPECT_FALSE(parse_edit(Kind::remove, text, kUav)) << text;
  }
  EXPECT_NE(parse_edit(Kind::replace, "2 fly", kUav).error().message.find("fly"), std::string::npos);
  EXPECT_FALSE(parse_edit(Kind::replace, "2", kUav));
  EXPECT_NE(parse_edit(Kind::insert, "0 move", kUav).error().message.find("position"), std::string::npos);
}

TEST(Edit, ATreeBeyondTheLimitsIsRefused) {
  std::string deep = "move";
  for (std::size_t i = 0; i < kMaxTreeDepth; ++i) {
    deep = "(selector " + deep + ")";
  }
  const auto result = apply_edits(kTree, {edit(Kind::replace, "4 " + deep)});
  ASSERT_FALSE(result);
  EXPECT_NE(result.error().message.find("after the changes"), std::string::npos) << result.error().message;
}

}  // namespace
}  // namespace coppice
