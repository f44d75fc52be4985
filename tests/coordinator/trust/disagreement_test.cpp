// What disagreement costs, and the best group against all there are.
#include "coordinator/trust/disagreement.hpp"

#include <algorithm>
#include <gtest/gtest.h>

#include "common/tree/text.hpp"
#include "common/tree/tick.hpp"
#include "coordinator/trust/tree_figures.hpp"
#include "tests/oracles/chains.hpp"
#include "tests/oracles/trees.hpp"

namespace coppice {
namespace {

// The most that one conjunction of at most two tests can save with every state weighing 1, by trying all of them.
double most_saved(const Chain& chain, const Tree& tree) {
  std::vector<Node> tests;
  for (std::size_t f = 0; f < chain.vocabulary().features.size(); ++f) {
    const Feature& feature = chain.vocabulary().features[f];
    for (const std::uint8_t value : feature.values) {
      if (feature.admits_equal && feature.values.size() > 1) {
        tests.push_back(Node::condition(f, Op::equal, value));
      }
      if (feature.admits_less_equal && value != feature.values.back()) {  // else it always holds
        tests.push_back(Node::condition(f, Op::less_equal, value));
      }
    }
  }
  const auto holds = [&](const Node& test, std::size_t state) {
    const std::uint8_t value = chain.features_of(state)[test.index];
    return test.op == Op::equal ? value == test.value : value <= test.value;
  };
  double most = 0.0;
  for (const Node& first : tests) {
    for (const Node& second : tests) {  // `first` itself among them: one test
      for (std::size_t action = 0; action < chain.actions(); ++action) {
        double saved = 0.0;
        for (std::size_t state = 0; state < chain.states(); ++state) {
          if (holds(first, state) && holds(second, state)) {
            const ActionId now = tick(tree, chain.features_of(state));
            const double value = now == kNoAction ? 0.0 : chain.parts().q[chain.row(state, now)];
            saved += chain.parts().q[state * chain.actions() + action] - value;
          }
        }
        most = std::max(most, saved);
      }
    }
  }
  return most;
}

TEST(Explain, TheFirstGroupIsAsGoodAsAnyThereIs) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Chain chain = oracles::random_chain({.states = 150, .actions = 3, .seed = seed});
    const Tree tree = oracles::random_trees(chain.vocabulary(), 1, seed).front();
    ExplainSettings settings{.weighting = Weighting::states, .steps = 20, .tests = 2, .groups = 3};
    const Explanation found = explain(chain, tree, settings);
    ASSERT_FALSE(found.groups.empty());
    EXPECT_TRUE(found.complete);
    const double most = most_saved(chain, tree);
    EXPECT_LE(found.groups[0].saved, most + 1e-9);
    // A shorter one may be taken for 5 % less.
    EXPECT_GE(found.groups[0].saved, (found.groups[0].tests.size() == 1 ? 0.95 : 1.0) * most - 1e-9) << "seed " << seed;
  }
}

TEST(Explain, CostsAddUpAndAGroupSavesWhatItSays) {
  const Chain chain = oracles::random_chain({.states = 200, .actions = 3, .seed = 2});
  const Tree tree = *parse_tree("(selector (sequence f0=0 a1) (sequence f1=1 f5<=1))", chain.vocabulary());
  ExplainSettings settings{.weighting = Weighting::states, .steps = 20, .tests = 3, .groups = 4};
  const Explanation before = explain(chain, tree, settings);
  double cost = 0.0;
  for (std::size_t i = 0; i < before.disagreements.size(); ++i) {
    const Disagreement& d = before.disagreements[i];
    cost += d.cost();
    EXPECT_EQ(d.tree, tick(tree, chain.features_of(d.state)));
    EXPECT_NE(d.tree, d.policy);
    EXPECT_TRUE(i == 0 || before.disagreements[i - 1].cost() >= d.cost());
  }
  EXPECT_NEAR(before.cost, cost, 1e-9);
  EXPECT_EQ(before.disagreements.size(), chain.states() - figures_of(chain, tree, 20).matching_states);
  Tree mended = with_branch(tree, branch_of(before.groups[0]));
  EXPECT_NEAR(explain(chain, mended, settings).cost, before.cost - before.groups[0].saved, 1e-9);
  // Later groups change what the earlier ones made: their branches come in front.
  mended = tree;
  double saved = 0.0;
  for (const Group& group : before.groups) {
    mended = with_branch(mended, branch_of(group));
    saved += group.saved;
    EXPECT_LE(group.mended, group.disagreements);
    EXPECT_LE(group.disagreements + group.spoilt, group.states);
  }
  EXPECT_NEAR(explain(chain, mended, settings).cost, before.cost - saved, 1e-9);
}

// With exact Q of the policy the cost of an endless, discounted walk is what the tree earns less; here the walk is one
// step, so that Q is the reward itself.
TEST(Explain, OverOneStepTheCostIsTheDifferenceInReward) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    ChainParts parts = oracles::random_chain({.states = 100, .actions = 3, .seed = seed}).parts();
    const Chain rewards = *Chain::make(parts);
    for (std::size_t row = 0; row < parts.q.size(); ++row) {
      parts.q[row] = rewards.mean_reward(row);
    }
    parts.policy = greedy_policy(parts.q, 3);
    const Chain chain = *Chain::make(parts);
    const Tree tree = *parse_tree("(selector (sequence f0=0 a1) a2)", chain.vocabulary());
    const Tree policy = Tree(chain.policy(chain.initial_state()));
    const Explanation found = explain(chain, tree, {.weighting = Weighting::tree, .steps = 1, .tests = 1, .groups = 0});
    EXPECT_NEAR(found.cost,
                figures_of(chain, policy, 1).along_chain.reward - figures_of(chain, tree, 1).along_chain.reward, 1e-9);
  }
}

TEST(Explain, SettingsOutOfRangeAreRefused) {
  EXPECT_FALSE(check_settings(ExplainSettings{.weighting = Weighting::tree, .steps = 0, .tests = 3, .groups = 5}));
  EXPECT_FALSE(check_settings(ExplainSettings{.weighting = Weighting::tree, .steps = 1, .tests = 0, .groups = 5}));
  EXPECT_FALSE(check_settings(ExplainSettings{.weighting = Weighting::tree, .steps = 1, .tests = 9, .groups = 5}));
  EXPECT_FALSE(value_named<Weighting>("weighting", "trees"));
  EXPECT_EQ(*value_named<Weighting>("weighting", "states"), Weighting::states);
}

}  // namespace
}  // namespace coppice
