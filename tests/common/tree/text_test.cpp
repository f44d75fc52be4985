#include "common/tree/text.hpp"

#include <gtest/gtest.h>

#include "tests/common/tree/arbitrary.hpp"

namespace coppice {
namespace {

Vocabulary windy() { return {{{"x", {0, 1, 2}, false, true}, {"y", {0, 1, 10}, true, true}}, {"up", "down"}}; }

TEST(TreeText, reads_and_writes_the_example_of_its_grammar) {
  const Vocabulary uav = arbitrary::uav();
  const std::string text = "(selector (sequence s3=0 turn_left) (sequence s1=3 s3=1 turn_left) move)";
  const Tree tree = arbitrary::tree(text, uav);
  ASSERT_EQ(tree.size(), 9U);
  EXPECT_EQ(tree[0], Node::composite(NodeKind::selector, 9));
  EXPECT_EQ(tree[1], Node::composite(NodeKind::sequence, 3));
  EXPECT_EQ(tree[5], Node::condition(1, Op::equal, 3));
  EXPECT_EQ(tree[8], Node::action(ActionId{0}));
  EXPECT_EQ(to_text(tree, uav), text);
}

TEST(TreeText, takes_blanks_anywhere_between_words) {
  const Vocabulary both = windy();
  EXPECT_EQ(to_text(arbitrary::tree(" \t(  selector\tx<=2(sequence y=10\ty<=0 down)up )  ", both), both),
            "(selector x<=2 (sequence y=10 y<=0 down) up)");
  EXPECT_EQ(to_text(arbitrary::tree("  up ", both), both), "up");
}

TEST(TreeText, of_thousands_of_random_trees_reads_back_as_the_same_tree) {
  Xoshiro256 random(21);
  const Below below = arbitrary::below_of(random);
  for (int round = 0; round < 5000; ++round) {
    const Vocabulary vocabulary = arbitrary::vocabulary(random, 1 + random.below(6), 5, 1 + random.below(5));
    const Tree tree = grow_tree(vocabulary, {random.below(7), 2 + random.below(4)}, false, below);
    const std::string text = to_text(tree, vocabulary);
    const Result<Tree> back = parse_tree(text, vocabulary);
    ASSERT_TRUE(back.has_value()) << text << ": " << back.error().message;
    ASSERT_EQ(*back, tree) << text;
  }
}

std::string refusal(std::string_view text, const Vocabulary& vocabulary) {
  const Result<Tree> tree = parse_tree(text, vocabulary);
  if (tree) {
    return "accepted";
  }
  EXPECT_EQ(tree.error().kind, ErrorKind::bad_input);
  return tree.error().message;
}

TEST(TreeText, that_is_wrong_gets_a_message_with_the_column_what_was_found_and_what_was_expected) {
  const Vocabulary both = windy();
  const std::string node = "a feature (x, y), an action (up, down) or '('";
  EXPECT_EQ(refusal("", both), "column 1: found the end: expected " + node);
  EXPECT_EQ(refusal(")", both), "column 1: found ')': expected " + node);
  EXPECT_EQ(refusal("(selector up", both), "column 13: found the end: expected " + node + ", or ')'");
  EXPECT_EQ(refusal("(parallel up)", both), "column 2: found 'parallel': expected 'sequence' or 'selector' after '('");
  EXPECT_EQ(refusal("(selector ( ) up)", both), "column 13: found ')': expected 'sequence' or 'selector' after '('");
  EXPECT_EQ(refusal("(selector (sequence) up)", both),
            "column 20: found ')': expected a child of the composite opened at column 11: " + node);
  EXPECT_EQ(refusal("(selector z=1 up)", both), "column 11: found 'z': expected " + node);
  EXPECT_EQ(refusal("(selector selector up)", both), "column 11: found 'selector': expected " + node);
  EXPECT_EQ(refusal("(selector x up)", both), "column 12: found ' ': expected '<=' after feature 'x'");
  EXPECT_EQ(refusal("(selector x=1 up)", both), "column 12: found '=': expected '<=' after feature 'x'");
  EXPECT_EQ(refusal("(selector y<1 up)", both), "column 12: found '<': expected '=' or '<=' after feature 'y'");
  EXPECT_EQ(refusal("(selector y<=2 up)", both),
            "column 14: found '2': expected a value of feature 'y': one of 0, 1, 10");
  for (const char* value : {"01", "1000", "-1", "+1", "1up", "", "99999999999999999999"}) {
    EXPECT_NE(refusal("y=" + std::string(value), both).find("column 3: found "), std::string::npos) << value;
  }
  EXPECT_EQ(refusal("y=1=1", both), "column 4: found '=': expected a blank or ')' after a condition");
  EXPECT_EQ(refusal("up=1", both), "column 3: found '=': expected a blank or ')' after an action");
  EXPECT_EQ(refusal("up down", both), "column 4: found 'd': expected the end: the tree is complete");
  EXPECT_EQ(refusal("(sequence up))", both), "column 14: found ')': expected the end: the tree is complete");
}

TEST(TreeText, with_foreign_characters_is_quoted_escaped_and_cut_short) {
  const Vocabulary both = windy();
  EXPECT_NE(refusal(std::string_view("(selector \0 up)", 15), both).find("column 11: found '\\x00'"),
            std::string::npos);
  EXPECT_NE(refusal("\x1b[31mup", both).find("column 1: found '\\x1b'"), std::string::npos);
  EXPECT_NE(refusal("up\n", both).find("column 3: found '\\x0a'"), std::string::npos);
  EXPECT_NE(refusal("\xc3\xa9", both).find("column 1: found '\\xc3'"), std::string::npos);
  EXPECT_LT(refusal(std::string(100'000, 'u'), both).size(), 200U);
}

TEST(TreeText, is_limited_in_depth_nodes_and_length) {
  const Vocabulary both = windy();
  const auto nested = [](std::size_t depth) {
    std::string text;
    for (std::size_t i = 0; i < depth; ++i) {
      text += "(sequence ";
    }
    return text + "up" + std::string(depth, ')');
  };
  EXPECT_EQ(refusal(nested(kMaxTreeDepth), both), "accepted");
  EXPECT_EQ(refusal(nested(kMaxTreeDepth + 1), both),
            "column 651: found a deeper node: expected at most 64 edges from the root");
  std::string unclosed;
  while (unclosed.size() + 10 <= kMaxTreeText) {
    unclosed += "(sequence ";
  }
  EXPECT_EQ(refusal(unclosed, both), "column 651: found a deeper node: expected at most 64 edges from the root");

  const auto wide = [](std::size_t nodes) {
    std::string text = "(selector";
    for (std::size_t i = 1; i < nodes; ++i) {
      text += " up";
    }
    return text + ")";
  };
  EXPECT_EQ(refusal(wide(kMaxTreeNodes), both), "accepted");
  EXPECT_EQ(refusal(wide(kMaxTreeNodes + 1), both),
            "column 12296: found one more node: expected at most 4096 nodes in a tree");

  EXPECT_EQ(refusal(std::string(kMaxTreeText - 2, ' ') + "up", both), "accepted");
  EXPECT_EQ(refusal(std::string(kMaxTreeText - 1, ' ') + "up", both),
            "tree text has 1048577 characters: expected at most 1048576");
}

TEST(TreeText, that_is_damaged_at_random_is_refused_or_gives_a_tree_of_the_vocabulary) {
  Xoshiro256 random(22);
  const Below below = arbitrary::below_of(random);
  const Vocabulary uav = arbitrary::uav();
  const std::string alphabet = "()=<s0137 \tmoveturn_left\n\xff";
  std::size_t accepted = 0;
  std::size_t refused = 0;
  for (int round = 0; round < 20'000; ++round) {
    std::string text = to_text(grow_tree(uav, {3, 3}, true, below), uav);
    for (std::uint64_t damage = 1 + random.below(3); damage > 0; --damage) {
      const std::size_t at = random.below(text.size());
      switch (random.below(3)) {
        case 0:
          text[at] = alphabet[random.below(alphabet.size())];
          break;
        case 1:
          text.insert(at, 1, alphabet[random.below(alphabet.size())]);
          break;
        default:
          text.erase(at, 1);
      }
    }
    const Result<Tree> tree = parse_tree(text, uav);
    if (tree) {
      ++accepted;
      ASSERT_TRUE(check_tree(*tree, uav).has_value()) << text;
      ASSERT_EQ(arbitrary::tree(to_text(*tree, uav), uav), *tree) << text;
    } else {
      ++refused;
      ASSERT_EQ(tree.error().message.rfind("column ", 0), 0U) << tree.error().message;
    }
  }
  EXPECT_GT(accepted, 100U);
  EXPECT_GT(refused, 100U);
}

}  // namespace
}  // namespace coppice
