#include "common/tree/simplify.hpp"

#include <gtest/gtest.h>

#include "common/tree/tick.hpp"
#include "tests/common/tree/arbitrary.hpp"

namespace coppice {
namespace {

std::string simplified(std::string_view text, const Vocabulary& vocabulary = arbitrary::uav()) {
  return to_text(simplify(arbitrary::tree(text, vocabulary), vocabulary).tree, vocabulary);
}

// Thesis Appendix A, the tree before pruning.
constexpr const char* kListingA1 =
    "(selector (sequence (selector turn_left s7=3) s3=0)"
    " (selector (sequence (sequence s3=0 s1=0 turn_right move) (sequence s6=0 s1=3 turn_right turn_right))"
    " move turn_left s6=3))";

TEST(Simplify, takes_the_thesis_listing_a1_to_where_listing_a4_ends) {
  EXPECT_EQ(simplified(kListingA1), "(selector (sequence turn_left s3=0) move)");
}

TEST(Simplify, drops_nodes_after_an_action_in_a_selector_as_in_listing_a1) {
  EXPECT_EQ(simplified("(selector (sequence s3=0 turn_right) move turn_left s6=3)"),
            "(selector (sequence s3=0 turn_right) move)");
  const Simplified result =
      simplify(arbitrary::tree("(selector (sequence s3=0 turn_right) move s6=3)", arbitrary::uav()), arbitrary::uav());
  ASSERT_EQ(result.removals.size(), 1U);
  EXPECT_EQ(result.removals[0].what, "s6=3");
  EXPECT_EQ(result.removals[0].reason, "never reached: it follows an action in a selector");
  EXPECT_EQ(result.removals[0].nodes, 1U);
}

TEST(Simplify, drops_an_action_overwritten_in_the_same_sequence_as_in_listing_a2) {
  EXPECT_EQ(simplified("(sequence s3=0 turn_right move)"), "(sequence s3=0 move)");
  EXPECT_EQ(simplified("(sequence turn_right (selector s3=0 turn_left) move)"), "move");
}

TEST(Simplify, keeps_an_action_when_something_between_it_and_the_next_can_fail) {
  EXPECT_EQ(simplified("(sequence turn_right s3=0 move)"), "(sequence turn_right s3=0 move)");
  EXPECT_EQ(simplified("(sequence move s4=1 turn_right)"), "(sequence move s4=1 turn_right)");
}

TEST(Simplify, drops_an_action_before_a_failing_branch_when_every_way_on_overwrites_it) {
  EXPECT_EQ(simplified("(selector (sequence turn_left s3=0 turn_right) move)"),
            "(selector (sequence s3=0 turn_right) move)");
}

TEST(Simplify, dissolves_composites_with_one_child_and_composites_inside_their_own_kind_as_in_listing_a3) {
  EXPECT_EQ(simplified("(selector (sequence (selector (sequence turn_left))))"), "turn_left");
  EXPECT_EQ(simplified("(sequence s3=0 (sequence s1=0 (sequence s2=0 move)))"), "(sequence s3=0 s1=0 s2=0 move)");
  EXPECT_EQ(simplified("(selector (selector (sequence s3=0 move) (sequence s4=0 turn_left)) turn_right)"),
            "(selector (sequence s3=0 move) (sequence s4=0 turn_left) turn_right)");
}

TEST(Simplify, drops_conditions_decided_by_what_was_tested_on_the_path_as_in_listing_a4) {
  EXPECT_EQ(simplified("(sequence s3=0 s3=0 move)"), "(sequence s3=0 move)");
  EXPECT_EQ(simplified("(selector (sequence s3=0 turn_left) (sequence s3=0 s1=0 turn_right) move)"),
            "(selector (sequence s3=0 turn_left) move)");
  EXPECT_EQ(simplified("(selector (sequence s3=0 turn_left) (sequence s3=1 turn_right) (sequence s3=3 move))"),
            "(selector (sequence s3=0 turn_left) (sequence s3=1 turn_right) move)");
}

TEST(Simplify, knows_that_at_most_restricts_the_values_both_ways) {
  const Vocabulary xy = {{{"x", {0, 1, 2, 3}, true, true}}, {"up", "down", "left"}};
  EXPECT_EQ(simplified("(selector (sequence x<=1 up) (sequence x<=2 x=2 down) left)", xy),
            "(selector (sequence x<=1 up) (sequence x<=2 down) left)");
  EXPECT_EQ(simplified("(selector (sequence x<=1 up) (sequence x=0 down) left)", xy),
            "(selector (sequence x<=1 up) left)");
  EXPECT_EQ(simplified("(selector (sequence x<=3 up) down)", xy), "up");
}

TEST(Simplify, drops_a_leading_or_trailing_node_that_changes_nothing) {
  EXPECT_EQ(simplified("(sequence s3=0 move s4=1)"), "(sequence s3=0 move)");
  EXPECT_EQ(simplified("(selector (sequence s3=0 move) s4=1)"), "(sequence s3=0 move)");
  EXPECT_EQ(simplified("(selector (sequence s3=0 s4=1 s3=1) move)"), "move");
  EXPECT_EQ(simplified("(selector (sequence s3=0 move) move)"), "move");
  EXPECT_EQ(simplified("(sequence move (selector s3=0 move))"), "move");
}

TEST(Simplify, drops_a_repeated_action_at_the_end_where_no_status_counts) {
  EXPECT_EQ(simplified("(selector (sequence move (selector s2=0 (sequence s0=0 turn_left))) move)"),
            "(sequence move (selector s2=0 (sequence s0=0 turn_left)))");
  EXPECT_EQ(simplified("(selector (sequence move (selector s2=0 (sequence s0=0 turn_left (selector s4=0 (sequence s1=0"
                       " turn_right) turn_left)))) move)"),
            "(sequence move (selector s2=0 (sequence s0=0 turn_left (selector s4=0 (sequence s1=0 turn_right)))))");
}

TEST(Simplify, leaves_a_tree_that_never_writes_as_one_valid_node) {
  const Vocabulary uav = arbitrary::uav();
  for (const char* text :
       {"s3=0", "(sequence s3=0 s4=1)", "(selector (sequence s3=0 s3=1 move) (sequence s1=0 s2=0))"}) {
    const Simplified result = simplify(arbitrary::tree(text, uav), uav);
    EXPECT_EQ(result.tree.size(), 1U) << text;
    EXPECT_EQ(result.tree[0].kind, NodeKind::condition) << text;
  }
}

// The vocabularies are small, so that the same tests and actions meet again and again on a path.
Tree drawn_tree(Xoshiro256& random, const Vocabulary& vocabulary) {
  return grow_tree(vocabulary, {1 + random.below(5), 2 + random.below(3)}, true, arbitrary::below_of(random));
}

TEST(Simplify, changes_no_tick_on_the_whole_feature_space_for_thousands_of_random_trees) {
  Xoshiro256 random(61);
  std::size_t before = 0;
  std::size_t after = 0;
  for (int space = 0; space < 200; ++space) {
    const Vocabulary vocabulary =
        arbitrary::vocabulary(random, 1 + random.below(3), 1 + random.below(3), 1 + random.below(4));
    const std::vector<std::uint8_t> rows = arbitrary::all_observations(vocabulary);
    const std::size_t states = rows.size() / vocabulary.features.size();
    for (int round = 0; round < 100; ++round) {
      const Tree tree = drawn_tree(random, vocabulary);
      const Simplified result = simplify(tree, vocabulary);
      const std::string text = to_text(tree, vocabulary) + " became " + to_text(result.tree, vocabulary);
      for (std::size_t s = 0; s < states; ++s) {
        const auto features = arbitrary::row(rows, vocabulary, s);
        ASSERT_EQ(tick(tree, features), tick(result.tree, features)) << "observation " << s << ": " << text;
      }
      ASSERT_TRUE(check_tree(result.tree, vocabulary).has_value()) << text;
      const Simplified again = simplify(result.tree, vocabulary);
      ASSERT_EQ(again.tree, result.tree) << text;
      ASSERT_TRUE(again.removals.empty()) << text;

      std::size_t removed = 0;
      for (const Removal& removal : result.removals) {
        ASSERT_GE(removal.nodes, 1U);
        ASSERT_FALSE(removal.reason.empty());
        ASSERT_TRUE(parse_tree(removal.what, vocabulary).has_value()) << removal.what;
        removed += removal.nodes;
      }
      ASSERT_EQ(removed, tree.size() - result.tree.size()) << text;
      before += tree.size();
      after += result.tree.size();
    }
  }
  EXPECT_LT(after * 3, before);
}

TEST(Simplify, leaves_no_composite_with_one_child_and_none_inside_its_own_kind) {
  Xoshiro256 random(62);
  const Vocabulary uav = arbitrary::uav();
  for (int round = 0; round < 1000; ++round) {
    const Tree tree = simplify(drawn_tree(random, uav), uav).tree;
    for (std::size_t i = 0; i < tree.size(); ++i) {
      if (tree[i].is_leaf()) {
        continue;
      }
      ASSERT_GE(child_count(tree.subtree(i)), 2U);
      for (std::size_t child = i + 1; child < i + tree[i].extent; child += tree[child].extent) {
        ASSERT_NE(tree[child].kind, tree[i].kind);
      }
    }
  }
}

TEST(Simplify, takes_a_tree_at_the_limits) {
  const Vocabulary uav = arbitrary::uav();
  Xoshiro256 random(63);
  const Tree tree = grow_tree(uav, {kMaxTreeDepth, 4}, true, arbitrary::below_of(random));
  const Tree result = simplify(tree, uav).tree;
  const std::vector<std::uint8_t> rows = arbitrary::all_observations(uav);
  for (std::size_t s = 0; s < rows.size() / uav.features.size(); ++s) {
    ASSERT_EQ(tick(tree, arbitrary::row(rows, uav, s)), tick(result, arbitrary::row(rows, uav, s)));
  }
}

}  // namespace
}  // namespace coppice
