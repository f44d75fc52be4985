#include "common/tree/guard.hpp"

#include <gtest/gtest.h>

#include "common/tree/decision_graph.hpp"
#include "common/tree/negation.hpp"
#include "common/tree/simplify.hpp"
#include "common/tree/tick.hpp"
#include "tests/common/tree/arbitrary.hpp"

namespace coppice {
namespace {

std::string guarded(std::string_view text, const Vocabulary& vocabulary = arbitrary::uav()) {
  const Result<Tree> result = guard(arbitrary::tree(text, vocabulary), vocabulary);
  return result ? to_text(*result, vocabulary) : result.error().message;
}

// A robot that acts at once: what it does in one tick, in order, and whether the tree succeeded.
struct Deeds {
  std::vector<ActionId> actions;
  bool succeeded = false;
};

bool do_node(const Tree& tree, std::size_t i, std::span<const std::uint8_t> features, std::vector<ActionId>& actions) {
  const Node& node = tree[i];
  if (node.kind == NodeKind::condition) {
    const std::uint8_t read = features[node.index];
    return node.op == Op::equal ? read == node.value : read <= node.value;
  }
  if (node.kind == NodeKind::action) {
    actions.push_back(node.action());
    return true;
  }
  const bool stops_at = node.kind == NodeKind::selector;
  for (std::size_t child = i + 1; child < i + node.extent; child += tree[child].extent) {
    if (do_node(tree, child, features, actions) == stops_at) {
      return stops_at;
    }
  }
  return !stops_at;
}

Deeds act(const Tree& tree, std::span<const std::uint8_t> features) {
  Deeds deeds;
  deeds.succeeded = do_node(tree, 0, features, deeds.actions);
  return deeds;
}

TEST(IsGuarded, asks_that_only_the_last_child_of_a_sequence_acts) {
  const Vocabulary uav = arbitrary::uav();
  for (const char* text : {"move", "s3=0", "(sequence s3=0 move)", "(selector (sequence s3=0 s1=0 move) turn_left)",
                           "(selector move turn_left)", "(sequence (selector s3=0 s1=0) move)",
                           "(sequence s3=0 (selector (sequence s1=0 move) turn_left))", "(selector s3=0 move)"}) {
    EXPECT_TRUE(is_guarded(arbitrary::tree(text, uav))) << text;
  }
  for (const char* text : {"(sequence move s3=0)", "(sequence move turn_left)", "(sequence (selector s3=0 move) s1=0)",
                           "(selector turn_left (sequence s3=0 (sequence s1=0 (selector move s1=3)) s0=0))"}) {
    EXPECT_FALSE(is_guarded(arbitrary::tree(text, uav))) << text;
  }
}

TEST(Guard, asks_before_it_acts_at_no_cost_where_a_sequence_is_turned_round) {
  EXPECT_EQ(guarded("(selector (sequence turn_left s3=0) move)"), "(selector (sequence s3=0 turn_left) move)");
  EXPECT_EQ(guarded("(sequence turn_left s3=0 s1=3)"), "turn_left");
  EXPECT_EQ(guarded("(selector (sequence turn_left s3=0) (sequence turn_right s1=0 s2=0) move)"),
            "(selector (sequence s3=0 turn_left) (sequence s1=0 s2=0 turn_right) move)");
}

TEST(Guard, makes_what_was_written_first_the_last_resort) {
  EXPECT_EQ(guarded("(sequence move s4=1 turn_right)"), "(selector (sequence s4=1 turn_right) move)");
  EXPECT_EQ(guarded("(sequence move (selector s3=0 s1=0) turn_right s2=0 turn_left)"),
            "(selector (sequence (selector s3=0 s1=0) (selector (sequence s2=0 turn_left) turn_right)) move)");
}

TEST(Guard, keeps_a_tree_from_acting_where_it_does_not_act) {
  EXPECT_EQ(guarded("(selector s3=0 move)"), "(selector s3=0 move)");
  EXPECT_EQ(guarded("(sequence s3=0 (selector s1=0 s2=0))"), "s3=0");
  EXPECT_EQ(guarded("(sequence (selector s3=0 move) s1=0 turn_left)"),
            "(selector (sequence s1=0 turn_left) s3=0 move)");
}

TEST(Guard, leaves_a_guarded_tree_as_simplify_does) {
  const char* text = "(selector (sequence s3=0 (selector (sequence s1=0 turn_left) turn_right)) move)";
  EXPECT_EQ(guarded(text), text);
}

TEST(Guard, says_the_opposite_of_a_test_where_that_is_shorter_than_writing_a_branch_twice) {
  const Vocabulary lamps = {{{"a", {0, 1}}, {"b", {0, 1}}, {"c", {0, 1}}, {"d", {0, 1}}}, {"x", "y", "z"}};
  // a=0: the rest decides; a=1 and b=0: x; a=1 and b=1: the rest again.
  EXPECT_EQ(guarded("(selector (sequence (selector a=0 b=1) c=0 d=0 y) (sequence a=1 b=0 x) z)", lamps),
            "(selector (sequence (selector a=0 b=1) c=0 d=0 y) (sequence a=1 b=0 x) z)");
}

TEST(Guard, changes_no_tick_on_the_whole_feature_space_and_acts_at_most_once_for_thousands_of_random_trees) {
  Xoshiro256 random(161);
  std::size_t simplified_nodes = 0;
  std::size_t guarded_nodes = 0;
  std::size_t never_acted = 0;
  for (int space = 0; space < 200; ++space) {
    const Vocabulary vocabulary =
        arbitrary::vocabulary(random, 1 + random.below(4), 1 + random.below(4), 1 + random.below(4));
    const std::vector<std::uint8_t> rows = arbitrary::all_observations(vocabulary);
    const std::size_t states = rows.size() / vocabulary.features.size();
    for (int round = 0; round < 50; ++round) {
      const Tree tree =
          grow_tree(vocabulary, {1 + random.below(5), 2 + random.below(3)}, true, arbitrary::below_of(random));
      const Result<Tree> result = guard(tree, vocabulary);
      ASSERT_TRUE(result.has_value()) << result.error().message << ": " << to_text(tree, vocabulary);
      const std::string text = to_text(tree, vocabulary) + " became " + to_text(*result, vocabulary);
      ASSERT_TRUE(is_guarded(*result)) << text;
      ASSERT_TRUE(check_tree(*result, vocabulary).has_value()) << text;
      for (std::size_t s = 0; s < states; ++s) {
        const auto features = arbitrary::row(rows, vocabulary, s);
        const ActionId wanted = tick(tree, features);
        ASSERT_EQ(tick(*result, features), wanted) << "observation " << s << ": " << text;
        const Deeds deeds = act(*result, features);
        ASSERT_EQ(deeds.actions, wanted == kNoAction ? std::vector<ActionId>() : std::vector<ActionId>{wanted}) << text;
        ASSERT_TRUE(deeds.succeeded || deeds.actions.empty()) << text;
        never_acted += wanted == kNoAction ? 1 : 0;
      }
      const Tree simplified = simplify(tree, vocabulary).tree;
      if (is_guarded(simplified)) {
        ASSERT_LE(result->size(), simplified.size()) << text;
      }
      ASSERT_LE(guard(*result, vocabulary)->size(), result->size()) << text;
      simplified_nodes += simplified.size();
      guarded_nodes += result->size();
    }
  }
  EXPECT_GT(never_acted, 0U);
  EXPECT_LT(guarded_nodes, simplified_nodes);
  RecordProperty("simplified_nodes", std::to_string(simplified_nodes));
  RecordProperty("guarded_nodes", std::to_string(guarded_nodes));
}

TEST(Guard, costs_few_nodes_on_the_thesis_room_of_eight_sensors) {
  Xoshiro256 random(162);
  const Vocabulary uav = arbitrary::uav();
  std::size_t simplified_nodes = 0;
  std::size_t guarded_nodes = 0;
  for (int round = 0; round < 500; ++round) {
    const Tree tree = grow_tree(uav, {2 + random.below(5), 4, 400}, true, arbitrary::below_of(random));
    const Result<Tree> result = guard(tree, uav);
    ASSERT_TRUE(result.has_value()) << result.error().message << ": " << to_text(tree, uav);
    simplified_nodes += simplify(tree, uav).tree.size();
    guarded_nodes += result->size();
    const std::vector<std::uint8_t> rows = arbitrary::observations(random, uav, 300);
    for (std::size_t s = 0; s < 300; ++s) {
      ASSERT_EQ(tick(*result, arbitrary::row(rows, uav, s)), tick(tree, arbitrary::row(rows, uav, s)))
          << to_text(tree, uav);
    }
  }
  EXPECT_LT(guarded_nodes * 100, simplified_nodes * 120);
  RecordProperty("simplified_nodes", std::to_string(simplified_nodes));
  RecordProperty("guarded_nodes", std::to_string(guarded_nodes));
}

TEST(Guard, takes_trees_at_the_limits_or_says_why_not) {
  const Vocabulary uav = arbitrary::uav();
  Xoshiro256 random(163);
  const std::vector<std::uint8_t> rows = arbitrary::observations(random, uav, 300);
  for (int round = 0; round < 20; ++round) {
    const Tree tree = grow_tree(uav, {kMaxTreeDepth, 4}, true, arbitrary::below_of(random));
    const Result<Tree> result = guard(tree, uav);
    if (!result) {
      EXPECT_EQ(result.error().kind, ErrorKind::bad_input);
      EXPECT_NE(result.error().message.find("expected at most"), std::string::npos);
      continue;
    }
    for (std::size_t s = 0; s < 300; ++s) {
      ASSERT_EQ(tick(tree, arbitrary::row(rows, uav, s)), tick(*result, arbitrary::row(rows, uav, s)));
    }
  }
}

TEST(Negation, holds_exactly_where_the_test_does_not) {
  Xoshiro256 random(164);
  std::size_t written = 0;
  for (int round = 0; round < 2000; ++round) {
    Vocabulary vocabulary = arbitrary::vocabulary(random, 1 + random.below(3), 4, 1);
    const Tree grown = grow_tree(vocabulary, {3, 3}, true, arbitrary::below_of(random));
    std::vector<Node> test(grown.nodes().begin(), grown.nodes().end());
    for (Node& node : test) {
      if (node.kind == NodeKind::action) {
        do {
          node = random_leaf(vocabulary, arbitrary::below_of(random));
        } while (node.kind == NodeKind::action);
      }
    }
    const std::optional<std::vector<Node>> opposite = negation(test, vocabulary);
    if (!opposite) {
      continue;
    }
    ++written;
    const Tree both[] = {*Tree::from_nodes(test), *Tree::from_nodes(*opposite)};
    ASSERT_TRUE(check_tree(both[1], vocabulary).has_value());
    const std::vector<std::uint8_t> rows = arbitrary::all_observations(vocabulary);
    for (std::size_t s = 0; s < rows.size() / vocabulary.features.size(); ++s) {
      const auto features = arbitrary::row(rows, vocabulary, s);
      ASSERT_NE(act(both[0], features).succeeded, act(both[1], features).succeeded)
          << to_text(both[0], vocabulary) << " and " << to_text(both[1], vocabulary);
    }
  }
  EXPECT_GT(written, 300U);
}

TEST(Negation, is_not_written_where_a_feature_has_no_operator_for_it) {
  const Vocabulary ordered = {{{"x", {0, 1, 2}, false, true}}, {"go"}};
  EXPECT_FALSE(negation({Node::condition(0, Op::less_equal, 0)}, ordered).has_value());
  EXPECT_EQ(always_true(ordered), std::vector<Node>{Node::condition(0, Op::less_equal, 2)});
}

}  // namespace
}  // namespace coppice
