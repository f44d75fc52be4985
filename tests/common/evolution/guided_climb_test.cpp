#include "common/evolution/guided_climb.hpp"

#include <gtest/gtest.h>
#include <utility>
#include <vector>

#include "common/chain/exact.hpp"
#include "common/fitness/objective.hpp"
#include "common/tree/action_table.hpp"
#include "common/tree/guard.hpp"
#include "common/tree/tree_size.hpp"
#include "tests/oracles/chains.hpp"
#include "tests/oracles/trees.hpp"

namespace coppice {
namespace {

constexpr double kGamma = 0.95;

class GuidedClimbTest : public ::testing::Test {
 protected:
  GuidedClimbTest() {
    job_.objectives = {Objective{ObjectiveKind::coverage}, Objective{ObjectiveKind::expected_return}};
    job_.method = Method::discounted;
    job_.gamma = fixed_point_share(kGamma);
    auto climb = GuidedClimb::make(chain_, job_);
    EXPECT_TRUE(climb.has_value());
    climb_ = std::move(*climb);
  }

  // Mean reward a step, by the occupancy of another solver.
  double mean_reward(const Tree& tree) {
    std::vector<std::uint8_t> actions(chain_.states());
    fill_action_table(tree, columns_, static_cast<std::uint8_t>(chain_.actions()), actions);
    const Occupancy* occupancy = exact_.discounted({.actions = actions, .others = {}}, kGamma);
    EXPECT_NE(occupancy, nullptr);
    double sum = 0.0;
    for (std::size_t i = 0; i < occupancy->states.size(); ++i) {
      const std::uint32_t s = occupancy->states[i];
      if (actions[s] < chain_.actions()) {
        sum += occupancy->visits[i] * chain_.mean_reward(chain_.row(s, ActionId{actions[s]}));
      }
    }
    return sum;
  }

  double covered(const Tree& tree) const {
    const std::vector<ActionId> actions = action_table(tree, columns_);
    std::size_t same = 0;
    for (std::size_t s = 0; s < actions.size(); ++s) {
      same += actions[s] == chain_.policy(s) ? 1 : 0;
    }
    return static_cast<double>(same);
  }

  Chain chain_ = oracles::random_chain({.states = 120, .actions = 3, .seed = 9});
  StateColumns columns_{chain_.vocabulary(), chain_.parts().features};
  ExactOccupancy exact_{chain_};
  Job job_;
  std::unique_ptr<GuidedClimb> climb_;
};

TEST_F(GuidedClimbTest, ends_with_a_tree_that_another_solver_finds_better_and_within_the_limits) {
  const EditLimits limits{.max_nodes = 25, .max_conditions = 6};
  std::size_t climbed = 0;
  for (const Tree& start : oracles::random_trees(chain_.vocabulary(), 60, 21)) {
    if (start.size() > limits.max_nodes || condition_count(start.nodes()) > limits.max_conditions) {
      continue;
    }
    const Tree end = climb_->climb(start, std::vector<double>{0.0, 1.0}, limits, {.steps = 100});
    EXPECT_LE(end.size(), limits.max_nodes);
    EXPECT_LE(condition_count(end.nodes()), limits.max_conditions);
    EXPECT_GE(mean_reward(end), mean_reward(start) - 1e-9);
    climbed += mean_reward(end) > mean_reward(start) + 1e-6 ? 1 : 0;
  }
  EXPECT_GT(climbed, 20U) << "random trees are no optima";
}

TEST_F(GuidedClimbTest, climbs_an_objective_over_states_without_solving_anything) {
  const Tree start{ActionId{0}};
  const Tree end =
      climb_->climb(start, std::vector<double>{1.0, 0.0}, {.max_nodes = 20, .max_conditions = 9}, {.steps = 100});
  EXPECT_GT(covered(end), covered(start));
  EXPECT_EQ(climb_->solved(), 0U);
}

TEST_F(GuidedClimbTest, takes_no_more_steps_than_it_may) {
  const Tree start{ActionId{0}};
  const Tree one = climb_->climb(start, std::vector<double>{1.0, 0.0}, {}, {.steps = 1});
  EXPECT_LE(one.size(), start.size() + 4);
  EXPECT_EQ(climb_->climb(start, std::vector<double>{1.0, 0.0}, {}, {.steps = 0}), start);
}

TEST_F(GuidedClimbTest, finds_the_best_tree_of_one_condition_that_there_is) {
  // All (selector (sequence c a) b), one by one.
  double best = -1e300;
  const auto action = [](std::size_t a) { return Node::action(ActionId{static_cast<std::uint8_t>(a)}); };
  for (std::size_t f = 0; f < chain_.vocabulary().features.size(); ++f) {
    for (const std::uint8_t value : chain_.vocabulary().features[f].values) {
      for (std::size_t a = 0; a < chain_.actions(); ++a) {
        for (std::size_t b = 0; b < chain_.actions(); ++b) {
          const auto tree =
              Tree::from_nodes({Node::composite(NodeKind::selector, 5), Node::composite(NodeKind::sequence, 3),
                                Node::condition(f, Op::equal, value), action(a), action(b)});
          ASSERT_TRUE(tree.has_value());
          best = std::max(best, mean_reward(*tree));
        }
      }
    }
  }
  double found = -1e300;
  for (std::size_t a = 0; a < chain_.actions(); ++a) {
    const Tree end = climb_->climb(Tree(ActionId{static_cast<std::uint8_t>(a)}), std::vector<double>{0.0, 1.0},
                                   {.max_nodes = 5, .max_conditions = 1}, {.steps = 100});
    found = std::max(found, mean_reward(end));
  }
  EXPECT_GE(found, best - 1e-9);
}

TEST_F(GuidedClimbTest, explores_to_the_best_list_of_two_conditions_that_there_is) {
  std::vector<Node> conditions;
  for (std::size_t f = 0; f < chain_.vocabulary().features.size(); ++f) {
    for (const std::uint8_t value : chain_.vocabulary().features[f].values) {
      conditions.push_back(Node::condition(f, Op::equal, value));
    }
  }
  const auto action = [](std::size_t a) { return Node::action(ActionId{static_cast<std::uint8_t>(a)}); };
  double best = -1e300;
  for (const Node& c : conditions) {
    for (const Node& d : conditions) {
      for (std::size_t which = 0; which < 27; ++which) {
        const auto tree = Tree::from_nodes(
            {Node::composite(NodeKind::selector, 8), Node::composite(NodeKind::sequence, 3), c, action(which % 3),
             Node::composite(NodeKind::sequence, 3), d, action(which / 3 % 3), action(which / 9)});
        ASSERT_TRUE(tree.has_value());
        best = std::max(best, mean_reward(*tree));
      }
    }
  }
  const EditLimits limits{.max_nodes = 9, .max_conditions = 2};
  const std::vector<Tree> found = climb_->explore(std::vector<double>{0.0, 1.0}, limits, 100'000);
  ASSERT_FALSE(found.empty());
  EXPECT_GE(mean_reward(found.front()), best - 1e-9);
  for (const Tree& tree : found) {
    EXPECT_LE(tree.size(), limits.max_nodes);
    EXPECT_LE(condition_count(tree.nodes()), limits.max_conditions);
    EXPECT_GE(mean_reward(found.front()), mean_reward(tree) - 1e-9) << "the best comes first";
  }
}

TEST_F(GuidedClimbTest, leaps_from_where_no_edit_helps) {
  // The policy is a1 where b0 and b1 differ: no action, condition or branch of one condition agrees in more than half
  // of the states, and a branch of two conditions in three quarters.
  ChainParts parts = oracles::random_chain({.states = 80, .actions = 2, .seed = 4}).parts();
  parts.vocabulary.features = {{"b0", {0, 1}, true, false}, {"b1", {0, 1}, true, false}};
  parts.features.clear();
  for (std::size_t s = 0; s < 80; ++s) {
    const auto b0 = static_cast<std::uint8_t>(s % 2);
    const auto b1 = static_cast<std::uint8_t>(s / 2 % 2);
    parts.features.insert(parts.features.end(), {b0, b1});
    parts.policy[s] = ActionId{static_cast<std::uint8_t>(b0 != b1 ? 1 : 0)};
  }
  parts.look_alikes = true;
  const auto chain = Chain::make(std::move(parts));
  ASSERT_TRUE(chain.has_value()) << chain.error().message;
  auto climb = GuidedClimb::make(*chain, job_);
  ASSERT_TRUE(climb.has_value());
  const StateColumns columns(chain->vocabulary(), chain->parts().features);
  const auto agreeing = [&](std::uint64_t leaps) {
    const Tree end =
        (*climb)->climb(Tree{ActionId{0}}, std::vector<double>{1.0, 0.0}, {.max_nodes = 17, .max_conditions = 4},
                        {.steps = 100, .pairs = false, .leaps = leaps});
    EXPECT_LE(condition_count(end.nodes()), 4U);
    const std::vector<ActionId> actions = action_table(end, columns);
    std::size_t same = 0;
    for (std::size_t s = 0; s < actions.size(); ++s) {
      same += actions[s] == chain->policy(s) ? 1 : 0;
    }
    return same;
  };
  EXPECT_EQ(agreeing(0), 40U);
  EXPECT_EQ(agreeing(100), 80U);
}

TEST_F(GuidedClimbTest, keeps_a_guarded_tree_guarded) {
  const Tree end = climb_->climb(Tree{ActionId{1}}, std::vector<double>{0.5, 1.0},
                                 {.max_nodes = 30, .max_conditions = 10, .guarded = true},
                                 {.steps = 100, .pairs = true, .leaps = 1000});
  EXPECT_TRUE(is_guarded(end));
  for (const Tree& tree :
       climb_->explore(std::vector<double>{0.5, 1.0}, {.max_nodes = 20, .max_conditions = 4, .guarded = true}, 2000)) {
    EXPECT_TRUE(is_guarded(tree));
  }
  EXPECT_GT(end.size(), 1U);
}

TEST_F(GuidedClimbTest, gives_the_same_tree_every_time) {
  const auto trees = oracles::random_trees(chain_.vocabulary(), 10, 22);
  auto other = GuidedClimb::make(chain_, job_);
  ASSERT_TRUE(other.has_value());
  for (auto tree = trees.rbegin(); tree != trees.rend(); ++tree) {  // in another order, with other scratch memory
    static_cast<void>((*other)->climb(*tree, std::vector<double>{0.3, 1.0}, {}, {.steps = 3}));
  }
  for (const Tree& tree : trees) {
    EXPECT_EQ(climb_->climb(tree, std::vector<double>{0.1, 1.0}, {}, {.steps = 10}),
              (*other)->climb(tree, std::vector<double>{0.1, 1.0}, {}, {.steps = 10}));
  }
}

}  // namespace
}  // namespace coppice
