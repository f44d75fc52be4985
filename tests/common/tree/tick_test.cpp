#include "common/tree/tick.hpp"

#include <array>
#include <gtest/gtest.h>

#include "tests/common/tree/arbitrary.hpp"

namespace coppice {
namespace {

using Sensors = std::array<std::uint8_t, 8>;

// The name of the action that the tree gives, "none" for none.
std::string ticked(std::string_view text, const Sensors& sensors) {
  const Vocabulary uav = arbitrary::uav();
  const ActionId action = tick(arbitrary::tree(text, uav), sensors);
  return action == kNoAction ? "none" : uav.actions[index_of(action)];
}

constexpr Sensors kFree = {1, 1, 1, 1, 1, 1, 1, 1};
constexpr Sensors kWallAhead = {1, 1, 1, 0, 1, 1, 1, 1};
constexpr Sensors kTrashLeft = {1, 3, 1, 1, 1, 1, 1, 1};

TEST(Tick, of_an_action_is_that_action_and_of_a_condition_is_none) {
  EXPECT_EQ(ticked("turn_left", kFree), "turn_left");
  EXPECT_EQ(ticked("s3=1", kFree), "none");
  EXPECT_EQ(ticked("s3=0", kFree), "none");
}

TEST(Tick, of_a_selector_stops_at_the_first_child_that_succeeds) {
  const char* text = "(selector (sequence s3=0 turn_left) (sequence s1=3 s3=1 turn_right) move)";
  EXPECT_EQ(ticked(text, kFree), "move");
  EXPECT_EQ(ticked(text, kWallAhead), "turn_left");
  EXPECT_EQ(ticked(text, kTrashLeft), "turn_right");
  EXPECT_EQ(ticked("(selector move turn_left)", kFree), "move");
  EXPECT_EQ(ticked("(selector s3=1 move)", kFree), "none");
}

TEST(Tick, of_a_sequence_stops_at_the_first_child_that_fails) {
  EXPECT_EQ(ticked("(sequence s3=0 move)", kFree), "none");
  EXPECT_EQ(ticked("(sequence s3=1 move)", kFree), "move");
  EXPECT_EQ(ticked("(sequence s3=1 s1=3 move)", kFree), "none");
}

TEST(Tick, takes_the_last_action_written) {
  EXPECT_EQ(ticked("(sequence move turn_left turn_right)", kFree), "turn_right");
  EXPECT_EQ(ticked("(sequence move (selector s3=0 turn_left) turn_right)", kFree), "turn_right");
}

TEST(Tick, keeps_an_action_of_a_branch_that_failed_later) {
  EXPECT_EQ(ticked("(sequence move s4=1 turn_right)", kFree), "turn_right");
  EXPECT_EQ(ticked("(sequence move s4=3 turn_right)", kFree), "move");
  // The root fails, and still the action counts.
  EXPECT_EQ(ticked("(selector (sequence turn_left s3=0) s4=3)", kFree), "turn_left");
  // The branch failed, a later one succeeded without writing.
  EXPECT_EQ(ticked("(selector (sequence turn_left s3=0) s4=1)", kFree), "turn_left");
  // A later branch overwrites it, even though that one fails too.
  EXPECT_EQ(ticked("(selector (sequence turn_left s3=0) (sequence turn_right s3=0) s4=3)", kFree), "turn_right");
  // Thesis Listing A.3: turn left at a wall, else the selector goes on and overwrites.
  EXPECT_EQ(ticked("(selector (sequence turn_left s3=0) move)", kWallAhead), "turn_left");
  EXPECT_EQ(ticked("(selector (sequence turn_left s3=0) move)", kFree), "move");
}

TEST(Tick, compares_as_the_operator_says) {
  const Vocabulary xy = {{{"x", {0, 4, 9}, true, true}}, {"up", "down"}};
  const auto name = [&xy](const char* text, std::uint8_t x) {
    const ActionId action = tick(arbitrary::tree(text, xy), std::array<std::uint8_t, 1>{x});
    return action == kNoAction ? std::string("none") : xy.actions[index_of(action)];
  };
  for (const auto& [x, at_most, equal] :
       {std::tuple{0, "up", "none"}, std::tuple{4, "up", "up"}, std::tuple{9, "none", "none"}}) {
    EXPECT_EQ(name("(sequence x<=4 up)", static_cast<std::uint8_t>(x)), at_most) << x;
    EXPECT_EQ(name("(sequence x=4 up)", static_cast<std::uint8_t>(x)), equal) << x;
  }
}

// The rules read off the text of section 3.1, with an explicit status and a trace of all writes.
struct Trace {
  std::vector<ActionId> written;
  bool run(const Tree& tree, std::size_t i, std::span<const std::uint8_t> features) {
    const Node& node = tree[i];
    if (node.kind == NodeKind::action) {
      written.push_back(node.action());
      return true;
    }
    if (node.kind == NodeKind::condition) {
      return node.op == Op::equal ? features[node.index] == node.value : features[node.index] <= node.value;
    }
    const bool stops_at = node.kind == NodeKind::selector;
    std::size_t child = i + 1;
    while (child < i + node.extent) {
      if (run(tree, child, features) == stops_at) {
        return stops_at;
      }
      child += tree[child].extent;
    }
    return !stops_at;
  }
};

TEST(Tick, of_random_trees_is_the_last_action_in_a_trace_of_all_writes) {
  Xoshiro256 random(31);
  const Below below = arbitrary::below_of(random);
  for (int round = 0; round < 2000; ++round) {
    const Vocabulary vocabulary = arbitrary::vocabulary(random, 3, 3, 1 + random.below(5));
    const Tree tree = grow_tree(vocabulary, {5, 4}, true, below);
    const std::vector<std::uint8_t> rows = arbitrary::observations(random, vocabulary, 20);
    for (std::size_t i = 0; i < 20; ++i) {
      Trace trace;
      trace.run(tree, 0, arbitrary::row(rows, vocabulary, i));
      const ActionId expected = trace.written.empty() ? kNoAction : trace.written.back();
      ASSERT_EQ(tick(tree, arbitrary::row(rows, vocabulary, i)), expected) << to_text(tree, vocabulary);
    }
  }
}

TEST(Tick, of_readings_is_that_of_the_values_that_they_have_in_every_scale) {
  Xoshiro256 random(32);
  const Vocabulary vocabulary = {{{"plain", {0, 3, 7}, true, true},
                                  {"number", {0, 1, 4}, true, true, Scale::numbers, {-1.5, 0.1, 20.0}},
                                  {"bin", {0, 1, 2}, false, true, Scale::bins, {-0.25, 1.0}}},
                                 {"a", "b", "c"}};
  const std::vector<std::vector<double>> readings = {{0.0, 3.0, 7.0}, {-1.5, 0.1, 20.0}, {-7.0, -0.25, 0.0, 1.0, 9.0}};
  for (int round = 0; round < 500; ++round) {
    const Tree tree = grow_tree(vocabulary, {4, 4}, true, arbitrary::below_of(random));
    std::vector<double> read;
    std::vector<std::uint8_t> values;
    for (std::size_t f = 0; f < readings.size(); ++f) {
      read.push_back(readings[f][random.below(readings[f].size())]);
      values.push_back(*vocabulary.features[f].value_of(read.back()));
    }
    ASSERT_EQ(tick_readings(tree, vocabulary, read), tick(tree, values)) << to_text(tree, vocabulary);
  }
}

TEST(Tick, of_readings_that_the_vocabulary_does_not_declare_compares_the_numbers) {
  const Vocabulary vocabulary = {{{"x", {0, 2}, true, true}}, {"a", "b", "c"}};
  const Tree tree = arbitrary::tree("(selector (sequence x=0 a) (sequence x<=2 b) c)", vocabulary);
  for (const auto& [reading, action] : {std::pair{0.0, 0}, std::pair{0.5, 1}, std::pair{-3.0, 1}, std::pair{1e9, 2}}) {
    EXPECT_EQ(tick_readings(tree, vocabulary, std::vector<double>{reading}),
              ActionId{static_cast<std::uint8_t>(action)});
  }
}

}  // namespace
}  // namespace coppice
