#include <gtest/gtest.h>

#include "common/tree/action_table.hpp"
#include "common/tree/simplify.hpp"
#include "tests/common/tree/arbitrary.hpp"

namespace coppice {
namespace {

TEST(SimplifyOnStates, keeps_the_action_table_of_thousands_of_random_trees_and_is_done_when_it_is_done) {
  Xoshiro256 random(71);
  std::size_t soundly = 0;
  std::size_t on_states = 0;
  for (int chain = 0; chain < 100; ++chain) {
    const Vocabulary vocabulary = arbitrary::vocabulary(random, 1 + random.below(6), 4, 1 + random.below(4));
    const StateColumns columns(vocabulary, arbitrary::observations(random, vocabulary, 1 + random.below(150)));
    for (int round = 0; round < 30; ++round) {
      const Tree tree = grow_tree(vocabulary, {1 + random.below(4), 4}, true, arbitrary::below_of(random));
      const Simplified result = simplify(tree, vocabulary, columns);
      const std::string text = to_text(tree, vocabulary) + " became " + to_text(result.tree, vocabulary);
      ASSERT_EQ(action_table(result.tree, columns), action_table(tree, columns)) << text;
      ASSERT_TRUE(check_tree(result.tree, vocabulary).has_value()) << text;
      ASSERT_EQ(simplify(result.tree, vocabulary).tree, result.tree) << text;
      const Simplified again = simplify(result.tree, vocabulary, columns);
      ASSERT_EQ(again.tree, result.tree) << text;
      ASSERT_TRUE(again.removals.empty()) << text;
      std::size_t removed = 0;
      for (const Removal& removal : result.removals) {
        removed += removal.nodes;
      }
      ASSERT_EQ(removed, tree.size() - result.tree.size()) << text;
      const std::size_t sound_size = simplify(tree, vocabulary).tree.size();
      ASSERT_LE(result.tree.size(), sound_size) << text;
      soundly += sound_size;
      on_states += result.tree.size();
    }
  }
  EXPECT_LT(on_states, soundly);
}

TEST(SimplifyOnStates, leaves_no_node_whose_removal_keeps_the_action_table) {
  Xoshiro256 random(72);
  const Vocabulary uav = arbitrary::uav();
  const StateColumns columns(uav, arbitrary::observations(random, uav, 300));
  for (int round = 0; round < 200; ++round) {
    const Tree tree = grow_tree(uav, {4, 4}, true, arbitrary::below_of(random));
    const Tree result = simplify(tree, uav, columns).tree;
    for (std::size_t i = 1; i < result.size(); ++i) {
      const Tree without = result.with_subtree(i, {});
      ASSERT_NE(action_table(without, columns), action_table(tree, columns))
          << "node " << i << " of " << to_text(result, uav);
    }
  }
}

TEST(SimplifyOnStates, drops_what_no_state_of_the_chain_shows_and_says_why) {
  const Vocabulary uav = arbitrary::uav();
  // Trash ahead is never seen, and a wall ahead only with a wall on the left.
  const std::vector<std::uint8_t> rows = {1, 1, 1, 1, 1, 1, 1, 1,  //
                                          1, 0, 1, 0, 1, 1, 1, 1,  //
                                          1, 0, 1, 1, 1, 1, 1, 1};
  const StateColumns columns(uav, rows);
  const Tree tree = arbitrary::tree(
      "(selector (sequence s3=3 (selector s2=1 turn_right) move) (sequence s1=0 s3=0 turn_left) move)", uav);
  const Simplified result = simplify(tree, uav, columns);
  EXPECT_EQ(to_text(result.tree, uav), "(selector (sequence s3=0 turn_left) move)");
  std::string log;
  for (const Removal& removal : result.removals) {
    log += removal.what + ": " + removal.reason + "\n";
  }
  EXPECT_EQ(log,
            "(selector s2=1 turn_right): always succeeds here and writes nothing that lasts\n"
            "(sequence s3=3 move): all 3 states keep their action without it\n"
            "s1=0: all 3 states keep their action without it\n");
}

TEST(SimplifyOnStates, hoists_the_only_useful_child_of_a_composite) {
  const Vocabulary uav = arbitrary::uav();
  const StateColumns columns(uav, std::vector<std::uint8_t>{0, 3, 3, 1, 1, 1, 1, 1, 3, 3, 0, 1, 1, 1, 1, 1});
  const Simplified result = simplify(arbitrary::tree("(sequence move s1=0 turn_left)", uav), uav, columns);
  EXPECT_EQ(to_text(result.tree, uav), "move");
  ASSERT_EQ(result.removals.size(), 1U);
  EXPECT_EQ(result.removals[0].reason, "in all 2 states its child move gives the same actions alone");
  EXPECT_EQ(result.removals[0].nodes, 3U);
}

}  // namespace
}  // namespace coppice
