#include "common/evolution/breeding.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "common/evolution/population.hpp"
#include "common/evolution/seeding.hpp"
#include "common/tree/guard.hpp"
#include "common/tree/text.hpp"
#include "common/tree/tick.hpp"
#include "tests/coordinator/evolution/small_world.hpp"

namespace coppice {
namespace {

using testing::small_vocabulary;
using testing::tree_of;

const Vocabulary kVocabulary = small_vocabulary();

// Written anew, so that it does not inherit a mistake of Breeding::within_limits().
void expect_within(const Tree& tree, const TreeShape& shape) {
  ASSERT_TRUE(Tree::from_nodes({tree.nodes().begin(), tree.nodes().end()}).has_value());
  ASSERT_TRUE(check_tree(tree, kVocabulary).has_value());
  ASSERT_LE(tree.size(), shape.max_nodes);
  ASSERT_LE(static_cast<std::size_t>(std::count_if(tree.nodes().begin(), tree.nodes().end(),
                                                   [](const Node& node) { return node.kind == NodeKind::condition; })),
            shape.max_conditions);
  if (shape.guarded) {
    ASSERT_TRUE(is_guarded(tree));
  }
  for (std::size_t i = 0; i < tree.size(); ++i) {
    ASSERT_LE(tree.depth_of(i), shape.max_depth);
    if (tree[i].is_composite()) {
      ASSERT_GE(child_count(tree.subtree(i)), 2U);
      ASSERT_LE(child_count(tree.subtree(i)), shape.max_children);
    }
  }
}

std::vector<Tree> first_generation(const Breeding& breeding, const GaConfig& ga) {
  EvolveConfig config;
  config.seed = 4;
  config.ga = ga;
  return first_population(breeding, config, testing::small_chain());
}

using NodeKey = std::tuple<int, int, int, int>;

std::vector<NodeKey> sorted_nodes(const std::vector<Tree>& trees) {
  std::vector<NodeKey> keys;
  for (const Tree& tree : trees) {
    for (const Node& node : tree.nodes()) {
      keys.emplace_back(static_cast<int>(node.kind), static_cast<int>(node.op), node.index, node.value);
    }
  }
  std::sort(keys.begin(), keys.end());
  return keys;
}

TEST(Breeding, EveryOperatorGivesWellFormedTreesWithinTheLimits) {
  for (const TreeShape shape :
       {TreeShape{3, 4}, TreeShape{1, 2}, TreeShape{0, 2}, TreeShape{5, 3}, TreeShape{12, 2}, TreeShape{6, 8, 12},
        TreeShape{4, 4, 2}, TreeShape{6, 8, 20, 3}, TreeShape{4, 4, 30, 0}, TreeShape{8, 6, 25, 5, true},
        TreeShape{3, 3, 7, 2, true}, TreeShape{0, 2, 1, 0, true}, TreeShape{10, 12, 60, 20, true}}) {
    const Breeding breeding(kVocabulary, shape);
    Stream stream(11, Purpose::breeding, static_cast<std::uint32_t>(shape.max_depth), 0);
    std::vector<Tree> pool;
    for (int i = 0; i < 40; ++i) {
      pool.push_back(breeding.grow(stream));
      expect_within(pool.back(), shape);
    }
    for (int i = 0; i < 2000; ++i) {
      const std::size_t a = stream.below(pool.size());
      const std::size_t b = stream.below(pool.size());
      auto [first, second] = breeding.crossover(stream, pool[a], pool[b]);
      expect_within(first, shape);
      expect_within(second, shape);
      pool[a] = breeding.mutate_leaf(stream, first);
      expect_within(pool[a], shape);
      pool[b] = breeding.mutate_subtree(stream, second);
      expect_within(pool[b], shape);
      pool[a] = breeding.edit(stream, pool[a]);
      expect_within(pool[a], shape);
      expect_within(breeding.simplified(pool[b]), shape);
      ASSERT_FALSE(HasFatalFailure());
    }
  }
}

TEST(Breeding, CrossoverLosesAndInventsNothing) {
  const Breeding breeding(kVocabulary, {4, 4});
  Stream stream(3, Purpose::breeding, 1, 0);
  for (int i = 0; i < 500; ++i) {
    const Tree a = breeding.grow(stream);
    const Tree b = breeding.grow(stream);
    const auto [first, second] = breeding.crossover(stream, a, b);
    ASSERT_EQ(sorted_nodes({a, b}), sorted_nodes({first, second}));
  }
}

TEST(Breeding, CrossoverCutsAtAnyNodeOfEitherParentThatTheLimitsAllow) {
  const TreeShape shape{2, 4};
  const Breeding breeding(kVocabulary, shape);
  const Tree a = tree_of("(selector (sequence a=0 a=1 left) a=3)");
  const Tree b = tree_of("(sequence b=0 (selector b=1 b=3 right) c=0)");
  std::set<std::pair<std::string, std::string>> possible;
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t j = 0; j < b.size(); ++j) {
      const Tree first = a.with_subtree(i, b.subtree(j));
      const Tree second = b.with_subtree(j, a.subtree(i));
      if (first.depth() <= shape.max_depth && second.depth() <= shape.max_depth) {
        possible.emplace(to_text(first, kVocabulary), to_text(second, kVocabulary));
      }
    }
  }
  std::set<std::pair<std::string, std::string>> seen;
  Stream stream(5, Purpose::breeding, 1, 0);
  for (int i = 0; i < 5000; ++i) {
    const auto [first, second] = breeding.crossover(stream, a, b);
    seen.emplace(to_text(first, kVocabulary), to_text(second, kVocabulary));
  }
  EXPECT_EQ(possible, seen);
  EXPECT_LT(possible.size(), a.size() * b.size()) << "the depth limit should rule some cuts out";
}

TEST(Breeding, MicroMutationChangesOneLeafAndNothingElse) {
  const Breeding breeding(kVocabulary, {3, 4});
  Stream stream(9, Purpose::breeding, 1, 0);
  std::set<std::size_t> touched;
  const Tree tree = tree_of("(selector (sequence a=0 d<=1 left) (sequence b=3 right) move)");
  for (int i = 0; i < 2000; ++i) {
    const Tree mutant = breeding.mutate_leaf(stream, tree);
    ASSERT_EQ(mutant.size(), tree.size());
    std::size_t changes = 0;
    for (std::size_t n = 0; n < tree.size(); ++n) {
      ASSERT_EQ(mutant[n].kind, tree[n].kind);
      ASSERT_EQ(mutant[n].extent, tree[n].extent);
      if (!(mutant[n] == tree[n])) {
        ++changes;
        touched.insert(n);
      }
    }
    ASSERT_LE(changes, 1U);
  }
  EXPECT_EQ(touched, (std::set<std::size_t>{2, 3, 4, 6, 7, 8}));
}

TEST(Breeding, MacroMutationReplacesOneSubtreeAndKeepsTheRest) {
  const Breeding breeding(kVocabulary, {4, 3});
  Stream stream(13, Purpose::breeding, 1, 0);
  for (int i = 0; i < 500; ++i) {
    const Tree tree = breeding.grow(stream);
    const Tree mutant = breeding.mutate_subtree(stream, tree);
    bool explained = false;
    for (std::size_t n = 0; n < tree.size() && !explained; ++n) {
      const std::size_t tail = tree.size() - n - tree[n].extent;
      if (n + tail < mutant.size() && n < mutant.size()) {
        explained = n + mutant[n].extent + tail == mutant.size() && tree.with_subtree(n, mutant.subtree(n)) == mutant;
      }
    }
    ASSERT_TRUE(explained) << to_text(tree, kVocabulary) << " became " << to_text(mutant, kVocabulary);
  }
}

TEST(Breeding, KeepsTheHardLimitOnNodes) {
  const TreeShape shape{kMaxTreeDepth, kMaxTreeNodes - 1};
  const Breeding breeding(kVocabulary, shape);
  std::string text = "(selector";
  for (std::size_t i = 0; i + 1 < kMaxTreeNodes; ++i) {
    text += " move";
  }
  const Tree full = tree_of(text + ")");
  ASSERT_EQ(full.size(), kMaxTreeNodes);
  const Tree small = tree_of("(sequence a=0 (selector b=0 left))");
  Stream stream(17, Purpose::breeding, 1, 0);
  for (int i = 0; i < 50; ++i) {
    const auto [first, second] = breeding.crossover(stream, full, small);
    expect_within(first, shape);
    expect_within(second, shape);
    expect_within(breeding.mutate_subtree(stream, full), shape);
    ASSERT_FALSE(HasFatalFailure());
  }
}

TEST(Breeding, IsAPureFunctionOfParentsAndStream) {
  const Breeding breeding(kVocabulary, {3, 4});
  for (std::uint32_t generation = 0; generation < 20; ++generation) {
    Stream one(1, Purpose::breeding, generation, 0);
    Stream two(1, Purpose::breeding, generation, 0);
    const Tree a = breeding.grow(one);
    ASSERT_EQ(a, breeding.grow(two));
    const Tree b = breeding.grow(one);
    ASSERT_EQ(b, breeding.grow(two));
    ASSERT_EQ(breeding.crossover(one, a, b), breeding.crossover(two, a, b));
    ASSERT_EQ(breeding.mutate_subtree(one, a), breeding.mutate_subtree(two, a));
  }
}

TEST(Breeding, AParentOutsideTheLimitsIsABug) {
  const Breeding breeding(kVocabulary, {1, 2});
  const Tree wide = tree_of("(sequence a=0 a=1 a=3 left)");
  Stream stream(1, Purpose::breeding, 1, 0);
  EXPECT_DEATH(breeding.mutate_leaf(stream, wide), "within_limits");
}

TEST(Population, ElitesComeFirstUnchangedAndTheRestIsFilled) {
  GaConfig ga;
  ga.population = 31;
  ga.elites = 3;
  const Breeding breeding(kVocabulary, ga.shape());
  const std::vector<Tree> parents = first_generation(breeding, ga);
  std::vector<double> fitness(parents.size());
  for (std::size_t slot = 0; slot < parents.size(); ++slot) {
    fitness[slot] = static_cast<double>(slot * 7 % 31);
  }
  for (const double crossover : {0.0, 0.5, 1.0}) {
    ga.crossover = crossover;
    const std::vector<Tree> next = next_population(breeding, {parents, fitness}, ga, 4, 1);
    ASSERT_EQ(next.size(), 31U);
    for (std::size_t elite = 0; elite < 3; ++elite) {
      const auto slot = std::find(fitness.begin(), fitness.end(), 30.0 - static_cast<double>(elite)) - fitness.begin();
      EXPECT_EQ(next[elite], parents[static_cast<std::size_t>(slot)]);
    }
    EXPECT_EQ(next, next_population(breeding, {parents, fitness}, ga, 4, 1));
    EXPECT_NE(next, next_population(breeding, {parents, fitness}, ga, 5, 1));
    EXPECT_NE(next, next_population(breeding, {parents, fitness}, ga, 4, 2));
  }
}

TEST(Population, WithoutCrossoverAndMutationEveryoneIsAParent) {
  GaConfig ga;
  ga.crossover = 0.0;
  ga.mutation = 0.0;
  const Breeding breeding(kVocabulary, ga.shape());
  const std::vector<Tree> parents = first_generation(breeding, ga);
  const std::vector<double> fitness(parents.size(), 1.0);
  for (const Tree& tree : next_population(breeding, {parents, fitness}, ga, 4, 1)) {
    EXPECT_NE(std::find(parents.begin(), parents.end(), tree), parents.end());
  }
}

TEST(Population, CountsDistinctTrees) {
  const std::vector<Tree> trees = {tree_of("move"),
                                   tree_of("left"),
                                   tree_of("move"),
                                   tree_of("(sequence a=0 left)"),
                                   tree_of("(selector a=0 left)"),
                                   tree_of("(sequence d=0 left)"),
                                   tree_of("(sequence d<=0 left)")};
  EXPECT_EQ(count_distinct(trees), 6U);
}

TEST(Breeding, EditsAreSmallAndReachEveryKindOfChange) {
  const Breeding breeding(kVocabulary, {4, 6, 20});
  const Tree tree = tree_of("(selector (sequence a=0 left) (sequence b=3 c=1 right) move)");
  Stream stream(21, Purpose::breeding, 1, 0);
  std::set<std::size_t> sizes;
  std::size_t unchanged = 0;
  for (int i = 0; i < 2000; ++i) {
    const Tree edited = breeding.edit(stream, tree);
    sizes.insert(edited.size());
    unchanged += edited == tree ? 1 : 0;
  }
  EXPECT_EQ(unchanged, 0U);
  for (const std::size_t size : {6U, 7U, 8U, 9U, 10U, 11U, 12U}) {
    EXPECT_EQ(sizes.count(size), 1U) << size << " nodes";
  }
}

TEST(Population, SeedsAreWithinTheLimitsAndTheGreedyOnesFollowThePolicy) {
  const Chain chain = testing::small_chain();
  for (const Seeding seeding : {Seeding::branches, Seeding::greedy}) {
    EvolveConfig config;
    config.ga.population = 60;
    config.ga.seeding = seeding;
    config.ga.max_nodes = 10;
    const Breeding breeding(kVocabulary, config.ga.shape());
    const std::vector<Tree> population = first_population(breeding, config, chain);
    std::size_t whole = 0;
    for (const Tree& tree : population) {
      expect_within(tree, config.ga.shape());
      std::size_t matches = 0;
      for (std::size_t state = 0; state < chain.states(); ++state) {
        matches += tick(tree, chain.features_of(state)) == chain.policy(state) ? 1 : 0;
      }
      whole += matches == chain.states() ? 1 : 0;
    }
    EXPECT_EQ(population, first_population(breeding, config, chain));
    EXPECT_NE(population, first_population(breeding, config, chain, 5)) << "another beginning has other trees";
    // The planted policy is a decision list of two branches.
    EXPECT_EQ(whole > 0, seeding == Seeding::greedy) << name_of(seeding);
  }
}

TEST(Population, FoundersTakeTheFirstSlotsAndChangeNoOther) {
  const Chain chain = testing::small_chain();
  EvolveConfig config;
  config.ga.population = 12;
  const Breeding breeding(kVocabulary, config.ga.shape());
  const std::vector<Tree> grown = first_population(breeding, config, chain);
  const std::vector<Tree> founders = {tree_of("(selector (sequence a=0 left) move)"), tree_of("right")};
  config.ga.founders = founders_text(founders, kVocabulary);
  EXPECT_EQ(config.ga.founders, "(selector (sequence a=0 left) move); right");
  const std::vector<Tree> begun = first_population(breeding, config, chain);
  ASSERT_EQ(begun.size(), 12U);
  for (std::size_t slot = 0; slot < begun.size(); ++slot) {
    EXPECT_EQ(begun[slot], slot < 2 ? founders[slot] : grown[slot]);
  }
  EXPECT_NE(first_population(breeding, config, chain, 5)[0], founders[0]) << "another beginning is without them";
}

}  // namespace
}  // namespace coppice
