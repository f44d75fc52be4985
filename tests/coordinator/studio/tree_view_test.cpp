// What each node of a tree does, against ticks that are counted by hand.
#include "coordinator/studio/tree_view.hpp"

#include <gtest/gtest.h>
#include <numeric>

#include "common/chain/random.hpp"
#include "common/tree/random_tree.hpp"
#include "common/tree/text.hpp"
#include "common/tree/tick.hpp"
#include "tests/coordinator/evolution/small_world.hpp"

namespace coppice {
namespace {

using testing::small_chain;
using testing::small_vocabulary;
using testing::tree_of;

constexpr std::uint32_t kSteps = 50;

TEST(TreeView, VisitsOfAWalkSumToItsSteps) {
  const Chain chain = small_chain();
  const std::vector<double> visits = expected_visits(chain, actions_of_policy(chain), kSteps);
  EXPECT_NEAR(std::accumulate(visits.begin(), visits.end(), 0.0), kSteps, 1e-9);
}

TEST(TreeView, CountsWhoIsTickedAndWhoDecides) {
  const Chain chain = small_chain();
  const Tree tree = tree_of("(selector (sequence a=0 left) (sequence b=3 right) move)");  // the policy
  const std::vector<double> ones(chain.states(), 1.0);
  const TreeView view = view_of(chain, tree, ones);
  // 81 states: a is 0 in 27; of the other 54 b is 3 in 18.
  EXPECT_EQ(view.steps, 81.0);
  EXPECT_EQ(view.nodes[0].ticked, 81.0);
  EXPECT_EQ(view.nodes[1].ticked, 81.0);
  EXPECT_EQ(view.nodes[2].succeeded, 27.0);
  EXPECT_EQ(view.nodes[3].decides, 27.0);
  EXPECT_EQ(view.nodes[5].ticked, 54.0);
  EXPECT_EQ(view.nodes[6].decides, 18.0);
  EXPECT_EQ(view.nodes[7].decides, 36.0);
  EXPECT_EQ(view.nodes[7].states, 36U);
  EXPECT_EQ(view.undecided, 0.0);
  for (const NodeView& node : view.nodes) {
    EXPECT_EQ(node.differs, 0.0);
  }
}

TEST(TreeView, OfAnyTreeEveryStepIsDecidedByOneNodeOrByNone) {
  const Chain chain = small_chain();
  Stream random(7, Purpose::growing, 0, 0);
  for (int i = 0; i < 200; ++i) {
    const Tree tree = grow_tree(chain.vocabulary(), {.max_depth = 4, .max_children = 4}, true,
                                [&](std::uint64_t n) { return random.below(n); });
    const std::vector<double> visits = expected_visits(chain, actions_of(chain, tree), kSteps);
    const TreeView view = view_of(chain, tree, visits);
    double decided = view.undecided;
    double differs = 0.0;
    for (std::size_t node = 0; node < tree.size(); ++node) {
      decided += view.nodes[node].decides;
      differs += view.nodes[node].differs;
      EXPECT_LE(view.nodes[node].succeeded, view.nodes[node].ticked + 1e-9);
      EXPECT_LE(view.nodes[node].decides, view.nodes[node].ticked + 1e-9);
    }
    EXPECT_NEAR(decided, kSteps, 1e-9);
    double expected = 0.0;
    for (std::size_t state = 0; state < chain.states(); ++state) {
      const ActionId action = tick(tree, chain.features_of(state));
      expected += action != kNoAction && action != chain.policy(state) ? visits[state] : 0.0;
    }
    EXPECT_NEAR(differs, expected, 1e-9) << to_text(tree, chain.vocabulary());
  }
}

}  // namespace
}  // namespace coppice
