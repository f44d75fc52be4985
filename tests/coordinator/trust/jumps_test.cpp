// A tick by jumps is a tick.
#include "coordinator/trust/jumps.hpp"

#include <gtest/gtest.h>

#include "common/tree/tick.hpp"
#include "tests/common/tree/arbitrary.hpp"

namespace coppice {
namespace {

TEST(Jumps, TheLastWriterWritesWhatATickGives) {
  Xoshiro256 random(1);
  const Below below = arbitrary::below_of(random);
  for (int i = 0; i < 500; ++i) {
    const Vocabulary vocabulary = arbitrary::vocabulary(random, 4, 3, 3);
    const Tree tree = grow_tree(vocabulary, {.max_depth = 5, .max_children = 4}, i % 2 == 0, below);
    const std::vector<Jump> jumps = jumps_of(tree);
    const auto rows = arbitrary::observations(random, vocabulary, 50);
    for (std::size_t r = 0; r < 50; ++r) {
      const auto features = arbitrary::row(rows, vocabulary, r);
      const std::size_t writer = last_writer(tree, jumps, features);
      ASSERT_EQ(writer == kTickEnds ? kNoAction : tree[writer].action(), tick(tree, features))
          << to_text(tree, vocabulary);
    }
  }
}

TEST(Jumps, AlwaysGoForward) {
  Xoshiro256 random(2);
  const Below below = arbitrary::below_of(random);
  const Vocabulary vocabulary = arbitrary::uav();
  for (int i = 0; i < 200; ++i) {
    const Tree tree = grow_tree(vocabulary, {.max_depth = 6, .max_children = 4}, true, below);
    const std::vector<Jump> jumps = jumps_of(tree);
    for (std::size_t node = 0; node < tree.size(); ++node) {
      ASSERT_GT(jumps[node].on_success, node);
      ASSERT_GT(jumps[node].on_failure, node);
    }
  }
}

}  // namespace
}  // namespace coppice
