// Chapter 4 of the thesis: Q-learning and SARSA on the windy grid until they converge, and a tree that follows the same
// shortest way.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "common/error.hpp"
#include "common/tree/tree.hpp"
#include "coordinator/learning/learn.hpp"
#include "coordinator/reproduce/comparison.hpp"

namespace coppice {

// One algorithm with one seed.
struct GridLearned {
  Learned learned;
  bool arrives = false;     // the greedy policy reaches the goal from the start
  std::uint32_t steps = 0;  // it takes, if it arrives
  double reward = 0.0;      // of that way
};

// Behind the episodes of Table 4-1 (ours has more: default_settings()) come this many without exploration.
inline constexpr std::uint64_t kGreedyEpisodes = 500;

LearnSettings grid_settings(Algorithm algorithm, std::uint64_t seed);
Result<GridLearned> learn_grid(Algorithm algorithm, std::uint64_t seed);

// The first episode after which no value of Q changes by kConvergedChange or more; 0 if it still does in the last.
std::uint64_t converged_in(const Learned& learned, const LearnSettings& settings);

// REQUIRES: as many of both, at least one, by seed from 1.
Comparison grid_learning_table(const std::vector<GridLearned>& q_learning, const std::vector<GridLearned>& sarsa);

// The tree that evolution found for a policy's way.
struct GridTree {
  Tree tree{ActionId{0}};
  std::uint64_t seed = 0;
  bool follows = false;  // it does what the policy does on every step of the policy's way, and so arrives
};

// The states of the greedy way, from the start on; empty when it does not arrive.
std::vector<std::size_t> greedy_way(const Chain& chain);
// Prunes a tree on the way alone: what it does elsewhere may change.
GridTree on_the_way(const Tree& tree, std::uint64_t seed, const Chain& chain);

Comparison grid_tree_table(const std::vector<GridTree>& trees, const GridLearned& policy);

}  // namespace coppice
