#include "common/tree/action_table.hpp"

#include <array>
#include <gtest/gtest.h>

#include "common/tree/tick.hpp"
#include "tests/common/tree/arbitrary.hpp"

namespace coppice {
namespace {

class ActionTableOfStates : public testing::TestWithParam<std::size_t> {};

TEST_P(ActionTableOfStates, equals_tick_on_every_state_for_random_trees) {
  const std::size_t states = GetParam();
  Xoshiro256 random(41 + states);
  const Below below = arbitrary::below_of(random);
  for (int chain = 0; chain < 20; ++chain) {
    const Vocabulary vocabulary = arbitrary::vocabulary(random, 1 + random.below(6), 4, 1 + random.below(5));
    const std::vector<std::uint8_t> rows = arbitrary::observations(random, vocabulary, states);
    const StateColumns columns(vocabulary, rows);
    ASSERT_EQ(columns.states(), states);
    for (int round = 0; round < 30; ++round) {
      const Tree tree = grow_tree(vocabulary, {random.below(7), 2 + random.below(4)}, false, below);
      const std::vector<ActionId> table = action_table(tree, columns);
      ASSERT_EQ(table.size(), states);
      for (std::size_t s = 0; s < states; ++s) {
        ASSERT_EQ(table[s], tick(tree, arbitrary::row(rows, vocabulary, s)))
            << "state " << s << " of " << to_text(tree, vocabulary);
      }
      std::vector<std::uint8_t> with_vectors(states);
      std::vector<std::uint8_t> without(states);
      fill_action_table(tree, columns, 0x7E, with_vectors, best_simd());
      fill_action_table(tree, columns, 0x7E, without, Simd::none);
      ASSERT_EQ(with_vectors, without);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(AroundTheBlockSizes, ActionTableOfStates,
                         testing::Values(1, 7, 8, 9, 63, 64, 65, 511, 512, 513, 1041));

TEST(ActionTable, tells_as_many_actions_apart_as_a_vocabulary_may_have) {
  Xoshiro256 random(42);
  const Vocabulary vocabulary = arbitrary::vocabulary(random, 4, 6, kMaxActions);
  const std::vector<std::uint8_t> rows = arbitrary::observations(random, vocabulary, 700);
  const StateColumns columns(vocabulary, rows);
  for (int round = 0; round < 300; ++round) {
    const Tree tree = grow_tree(vocabulary, {5, 5}, true, arbitrary::below_of(random));
    const std::vector<ActionId> table = action_table(tree, columns);
    for (std::size_t s = 0; s < table.size(); ++s) {
      ASSERT_EQ(table[s], tick(tree, arbitrary::row(rows, vocabulary, s))) << to_text(tree, vocabulary);
    }
  }
}

TEST(ActionTable, marks_the_states_without_action_as_it_is_told) {
  const Vocabulary uav = arbitrary::uav();
  Xoshiro256 random(43);
  const std::vector<std::uint8_t> rows = arbitrary::observations(random, uav, 130);
  const StateColumns columns(uav, rows);
  const Tree tree = arbitrary::tree("(sequence s3=0 turn_right)", uav);
  for (const std::uint8_t none : std::array<std::uint8_t, 7>{0x00, 0x01, 0x03, 0x7F, 0x80, 0xFE, 0xFF}) {
    std::vector<std::uint8_t> table(columns.states(), 0x55);
    fill_action_table(tree, columns, none, table);
    for (std::size_t s = 0; s < table.size(); ++s) {
      ASSERT_EQ(table[s], arbitrary::row(rows, uav, s)[3] == 0 ? 2 : none);
    }
  }
}

TEST(ActionTable, of_a_tree_at_the_limits_equals_tick) {
  const Vocabulary uav = arbitrary::uav();
  Xoshiro256 random(44);
  const std::vector<std::uint8_t> rows = arbitrary::observations(random, uav, 100);
  const StateColumns columns(uav, rows);
  const Tree tree = grow_tree(uav, {kMaxTreeDepth, 4}, true, arbitrary::below_of(random));
  const std::vector<ActionId> table = action_table(tree, columns);
  for (std::size_t s = 0; s < table.size(); ++s) {
    ASSERT_EQ(table[s], tick(tree, arbitrary::row(rows, uav, s)));
  }
}

TEST(StateColumns, hold_one_bit_per_condition_and_state_and_zeros_behind_the_last_state) {
  Xoshiro256 random(45);
  for (const std::size_t states : {1, 64, 65, 512, 1041}) {
    const Vocabulary vocabulary = arbitrary::vocabulary(random, 3, 5, 1);
    const std::vector<std::uint8_t> rows = arbitrary::observations(random, vocabulary, states);
    const StateColumns columns(vocabulary, rows);
    ASSERT_EQ(columns.words() % StateColumns::kBlockWords, 0U);
    ASSERT_GE(columns.words() * 64, states);
    const auto bit = [](const std::uint64_t* column, std::size_t s) { return (column[s / 64] >> (s % 64)) & 1U; };
    for (std::size_t f = 0; f < vocabulary.features.size(); ++f) {
      for (const Op op : {Op::equal, Op::less_equal}) {
        for (const std::uint8_t value : vocabulary.features[f].values) {
          if (!vocabulary.features[f].admits(op)) {
            continue;
          }
          const std::uint64_t* column = columns.column(Node::condition(f, op, value));
          for (std::size_t s = 0; s < columns.words() * 64; ++s) {
            ASSERT_EQ(bit(columns.all(), s), s < states ? 1U : 0U);
            const bool holds = s < states && (op == Op::equal ? arbitrary::row(rows, vocabulary, s)[f] == value
                                                              : arbitrary::row(rows, vocabulary, s)[f] <= value);
            ASSERT_EQ(bit(column, s), holds ? 1U : 0U) << "state " << s;
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace coppice
