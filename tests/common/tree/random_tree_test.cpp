#include "common/tree/random_tree.hpp"

#include <gtest/gtest.h>
#include <map>

#include "tests/common/tree/arbitrary.hpp"

namespace coppice {
namespace {

TEST(GrowTree, stays_within_its_shape_and_vocabulary_for_thousands_of_draws) {
  Xoshiro256 random(51);
  const Below below = arbitrary::below_of(random);
  for (int round = 0; round < 10'000; ++round) {
    const Vocabulary vocabulary = arbitrary::vocabulary(random, 1 + random.below(8), 4, 1 + random.below(5));
    const TreeShape shape{random.below(6), 2 + random.below(4)};
    const bool composite_root = random.below(2) == 0;
    const Tree tree = grow_tree(vocabulary, shape, composite_root, below);
    ASSERT_LE(tree.depth(), shape.max_depth);
    ASSERT_TRUE(check_tree(tree, vocabulary).has_value());
    if (composite_root && shape.max_depth > 0) {
      ASSERT_TRUE(tree[0].is_composite());
    }
    for (std::size_t i = 0; i < tree.size(); ++i) {
      if (tree[i].is_composite()) {
        const std::size_t children = child_count(tree.subtree(i));
        ASSERT_GE(children, 2U);
        ASSERT_LE(children, shape.max_children);
      }
    }
  }
}

TEST(GrowTree, reaches_every_depth_and_child_count_that_its_shape_allows) {
  Xoshiro256 random(52);
  std::map<std::size_t, int> depths;
  std::map<std::size_t, int> children;
  for (int round = 0; round < 2000; ++round) {
    const Tree tree = grow_tree(arbitrary::uav(), {3, 4}, true, arbitrary::below_of(random));
    ++depths[tree.depth()];
    ++children[child_count(tree.nodes())];
  }
  EXPECT_EQ(depths.size(), 3U);    // 1, 2, 3
  EXPECT_EQ(children.size(), 3U);  // 2, 3, 4
}

TEST(GrowTree, stays_within_the_limits_of_every_tree_at_the_widest_and_deepest_shape) {
  Xoshiro256 random(53);
  std::size_t largest = 0;
  for (int round = 0; round < 50; ++round) {
    const std::size_t max_children = round % 2 == 0 ? 10 : 100'000;
    const Tree tree = grow_tree(arbitrary::uav(), {kMaxTreeDepth, max_children}, true, arbitrary::below_of(random));
    ASSERT_LE(tree.size(), kMaxTreeNodes);
    ASSERT_LE(tree.depth(), kMaxTreeDepth);
    largest = std::max(largest, tree.size());
  }
  EXPECT_GT(largest, kMaxTreeNodes * 9 / 10);
}

TEST(GrowTree, gives_the_same_tree_for_the_same_draws) {
  Xoshiro256 one(54);
  Xoshiro256 other(54);
  for (int round = 0; round < 100; ++round) {
    ASSERT_EQ(grow_tree(arbitrary::uav(), {}, true, arbitrary::below_of(one)),
              grow_tree(arbitrary::uav(), {}, true, arbitrary::below_of(other)));
  }
}

TEST(RandomLeaf, draws_every_condition_and_action_of_the_vocabulary_and_conditions_as_often_as_actions) {
  const Vocabulary vocabulary = {{{"x", {0, 4}, true, true}, {"y", {1, 2, 3}, false, true}}, {"up", "down"}};
  Xoshiro256 random(55);
  std::map<std::string, int> drawn;
  int conditions = 0;
  const int draws = 20'000;
  for (int i = 0; i < draws; ++i) {
    const Node leaf = random_leaf(vocabulary, arbitrary::below_of(random));
    conditions += leaf.kind == NodeKind::condition ? 1 : 0;
    ++drawn[to_text(leaf, vocabulary)];
  }
  EXPECT_EQ(drawn.size(), 9U);                 // x=0 x=4 x<=0 x<=4 y<=1 y<=2 y<=3 up down
  EXPECT_NEAR(conditions, draws / 2, 5 * 71);  // five standard deviations
  EXPECT_NEAR(drawn["up"], draws / 4, 5 * 62);
  EXPECT_NEAR(drawn["y<=2"], draws / 12, 5 * 39);
}

TEST(MutatedLeaf, is_another_leaf_of_the_same_kind) {
  const Vocabulary uav = arbitrary::uav();
  Xoshiro256 random(56);
  const Below below = arbitrary::below_of(random);
  std::map<std::string, int> drawn;
  for (int i = 0; i < 5000; ++i) {
    const Node leaf = random_leaf(uav, below);
    const Node mutated = mutated_leaf(leaf, uav, below);
    ASSERT_EQ(mutated.kind, leaf.kind);
    ASSERT_FALSE(mutated == leaf);
    ASSERT_TRUE(check_tree(*Tree::from_nodes({mutated}), uav).has_value());
    ++drawn[to_text(mutated, uav)];
  }
  EXPECT_EQ(drawn.size(), 8U * 3U + 3U);
}

TEST(MutatedLeaf, of_a_vocabulary_with_one_condition_and_one_action_is_the_leaf_itself) {
  const Vocabulary poor = {{{"x", {7}}}, {"wait"}};
  Xoshiro256 random(57);
  const Below below = arbitrary::below_of(random);
  EXPECT_EQ(mutated_leaf(Node::action(ActionId{0}), poor, below), Node::action(ActionId{0}));
  EXPECT_EQ(mutated_leaf(Node::condition(0, Op::equal, 7), poor, below), Node::condition(0, Op::equal, 7));
}

}  // namespace
}  // namespace coppice
