// Random trees for property tests.
#pragma once

#include <cstdint>
#include <vector>

#include "common/chain/random.hpp"
#include "common/tree/random_tree.hpp"

namespace coppice::oracles {

inline std::vector<Tree> random_trees(const Vocabulary& vocabulary, std::size_t count, std::uint64_t seed) {
  Xoshiro256 random(seed);
  const Below below = [&random](std::uint64_t n) { return random.below(n); };
  std::vector<Tree> trees;
  for (std::size_t i = 0; i < count; ++i) {
    trees.push_back(grow_tree(vocabulary, {.max_depth = 1 + i % 4, .max_children = 4}, i % 3 != 0, below));
  }
  return trees;
}

}  // namespace coppice::oracles
