#include "common/tree/tree.hpp"

#include <gtest/gtest.h>

#include "common/tree/tree_checker.hpp"
#include "tests/common/tree/arbitrary.hpp"

namespace coppice {
namespace {

Node sequence(std::size_t extent) { return Node::composite(NodeKind::sequence, extent); }
Node act(std::uint8_t index) { return Node::action(ActionId{index}); }

std::string refusal_of_nodes(std::vector<Node> nodes) {
  const Result<Tree> tree = Tree::from_nodes(std::move(nodes));
  return tree ? "accepted" : tree.error().message;
}

TEST(Tree, of_malformed_nodes_is_refused_with_the_node_and_what_was_expected) {
  EXPECT_EQ(refusal_of_nodes({}), "tree has 0 nodes: expected 1 to 4096");
  EXPECT_EQ(refusal_of_nodes({act(0), act(0)}), "tree's root spans 1 nodes of 2: expected one tree");
  EXPECT_EQ(refusal_of_nodes({sequence(3), act(0)}), "tree's root spans 3 nodes of 2: expected one tree");
  EXPECT_EQ(refusal_of_nodes({sequence(1)}), "node 0 is a composite without children: expected 1 or more");
  EXPECT_EQ(refusal_of_nodes({sequence(3), sequence(3), act(0)}), "node 1 spans 3 nodes, which leaves its parent");
  EXPECT_EQ(refusal_of_nodes({sequence(4), sequence(2), sequence(2), act(0)}),
            "node 2 spans 2 nodes, which leaves its parent");
  Node leaf_with_child = act(0);
  leaf_with_child.extent = 2;
  EXPECT_EQ(refusal_of_nodes({sequence(3), leaf_with_child, act(0)}), "node 1 is a leaf but spans 2 nodes");
  Node nothing = act(0);
  nothing.extent = 0;
  EXPECT_EQ(refusal_of_nodes({sequence(3), nothing, act(0)}), "node 1 spans 0 nodes, which leaves its parent");
}

std::vector<Node> chain_of_depth(std::size_t depth) {
  std::vector<Node> nodes;
  for (std::size_t left = depth; left > 0; --left) {
    nodes.push_back(sequence(left + 1));
  }
  nodes.push_back(act(0));
  return nodes;
}

TEST(Tree, may_be_as_deep_and_as_large_as_the_limits_and_not_more) {
  const Result<Tree> deepest = Tree::from_nodes(chain_of_depth(kMaxTreeDepth));
  ASSERT_TRUE(deepest.has_value()) << deepest.error().message;
  EXPECT_EQ(deepest->depth(), kMaxTreeDepth);
  EXPECT_EQ(deepest->depth_of(kMaxTreeDepth), kMaxTreeDepth);
  EXPECT_EQ(refusal_of_nodes(chain_of_depth(kMaxTreeDepth + 1)), "tree is deeper than 64 edges at node 65");

  std::vector<Node> largest(kMaxTreeNodes, act(0));
  largest.front() = sequence(kMaxTreeNodes);
  EXPECT_EQ(refusal_of_nodes(largest), "accepted");
  largest.push_back(act(0));
  largest.front() = sequence(kMaxTreeNodes + 1);
  EXPECT_EQ(refusal_of_nodes(largest), "tree has 4097 nodes: expected 1 to 4096");
}

TEST(Tree, knows_the_depth_of_every_node) {
  const Tree tree = arbitrary::tree("(selector (sequence s3=0 (selector s1=1 move)) turn_left)", arbitrary::uav());
  const std::vector<std::size_t> depths = {0, 1, 2, 2, 3, 3, 1};
  ASSERT_EQ(tree.size(), depths.size());
  for (std::size_t i = 0; i < depths.size(); ++i) {
    EXPECT_EQ(tree.depth_of(i), depths[i]) << "node " << i;
  }
  EXPECT_EQ(tree.depth(), 3U);
  EXPECT_EQ(child_count(tree.nodes()), 2U);
  EXPECT_EQ(child_count(tree.subtree(2)), 0U);
}

TEST(Tree, with_a_subtree_replaced_reads_like_the_text_with_its_words_replaced) {
  const Vocabulary uav = arbitrary::uav();
  const Tree tree = arbitrary::tree("(selector (sequence s3=0 (selector s1=1 move)) turn_left)", uav);
  const Tree graft = arbitrary::tree("(sequence s5=3 turn_right)", uav);
  EXPECT_EQ(to_text(tree.with_subtree(3, graft.nodes()), uav),
            "(selector (sequence s3=0 (sequence s5=3 turn_right)) turn_left)");
  EXPECT_EQ(to_text(tree.with_subtree(0, tree.subtree(3)), uav), "(selector s1=1 move)");
  EXPECT_EQ(to_text(tree.with_subtree(6, tree.nodes()), uav),
            "(selector (sequence s3=0 (selector s1=1 move)) "
            "(selector (sequence s3=0 (selector s1=1 move)) turn_left))");
  EXPECT_EQ(to_text(tree.with_subtree(2, {}), uav), "(selector (sequence (selector s1=1 move)) turn_left)");
}

TEST(Tree, with_a_random_subtree_replaced_by_a_random_tree_stays_well_formed) {
  const Vocabulary uav = arbitrary::uav();
  Xoshiro256 random(11);
  const Below below = arbitrary::below_of(random);
  for (int round = 0; round < 5000; ++round) {
    const Tree tree = grow_tree(uav, {4, 4}, false, below);
    const Tree graft = grow_tree(uav, {3, 3}, false, below);
    const std::size_t i = random.below(tree.size());
    const Tree result = tree.with_subtree(i, graft.nodes());
    ASSERT_EQ(result.size(), tree.size() - tree[i].extent + graft.size());
    const Result<Tree> checked = Tree::from_nodes({result.nodes().begin(), result.nodes().end()});
    ASSERT_TRUE(checked.has_value()) << checked.error().message;
    EXPECT_TRUE(std::equal(graft.nodes().begin(), graft.nodes().end(), result.subtree(i).begin()));
    EXPECT_EQ(result.with_subtree(i, tree.subtree(i)), tree);
  }
}

TEST(Tree, of_another_vocabulary_is_refused_with_the_node) {
  const Vocabulary uav = arbitrary::uav();
  const auto refusal_of = [&uav](Node leaf) {
    const Result<void> checked = check_tree(*Tree::from_nodes({sequence(3), act(0), leaf}), uav);
    return checked ? std::string("accepted") : checked.error().message;
  };
  EXPECT_EQ(refusal_of(Node::condition(7, Op::equal, 3)), "accepted");
  EXPECT_EQ(refusal_of(act(3)), "node 2 has action 3: expected 0 to 2");
  EXPECT_EQ(refusal_of(Node::condition(8, Op::equal, 0)), "node 2 tests feature 8: expected 0 to 7");
  EXPECT_EQ(refusal_of(Node::condition(0, Op::equal, 2)),
            "node 2: feature 's0' never reads 2: expected one of 0, 1, 3");
  EXPECT_EQ(refusal_of(Node::condition(0, Op::less_equal, 1)), "node 2: feature 's0' does not admit operator '<='");
}

TEST(TreeChecker, says_what_check_tree_says_of_every_leaf) {
  Vocabulary words = arbitrary::uav();
  words.features[1].admits_less_equal = true;
  words.features[2].admits_equal = false;
  words.features[2].admits_less_equal = true;
  const TreeChecker checker(words);
  const auto expect_the_same = [&](const Node& leaf) {
    const Tree tree = *Tree::from_nodes({sequence(3), act(0), leaf});
    const Result<void> expected = check_tree(tree, words);
    const Result<void> said = checker.check(tree);
    ASSERT_EQ(checker.admits(tree), expected.has_value());
    ASSERT_EQ(said.has_value(), expected.has_value());
    if (!said) {
      EXPECT_EQ(said.error().message, expected.error().message);
    }
  };
  for (unsigned index = 0; index < 256; ++index) {
    expect_the_same(act(static_cast<std::uint8_t>(index)));
    for (unsigned value = 0; value < 256; ++value) {
      expect_the_same(Node::condition(index, Op::equal, static_cast<std::uint8_t>(value)));
      expect_the_same(Node::condition(index, Op::less_equal, static_cast<std::uint8_t>(value)));
    }
  }
}

}  // namespace
}  // namespace coppice
