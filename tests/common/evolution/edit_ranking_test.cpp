#include "common/evolution/edit_ranking.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <vector>

#include "common/evolution/tree_draft.hpp"
#include "common/tree/action_table.hpp"
#include "common/tree/guard.hpp"
#include "common/tree/tick.hpp"
#include "common/tree/tree_size.hpp"
#include "tests/oracles/chains.hpp"
#include "tests/oracles/trees.hpp"

namespace coppice {
namespace {

class EditRankingTest : public ::testing::Test {
 protected:
  EditRankingTest() {
    Xoshiro256 random(7);
    for (std::size_t i = 0; i < chain_.states() * (chain_.actions() + 1); ++i) {
      gains_.push_back(random.below(4) == 0 ? 0.0 : static_cast<double>(random.below(2001)) - 1000.0);
    }
  }

  // By ticking the tree in every state.
  double ticked_gain(const Tree& tree) const {
    double sum = 0.0;
    for (std::size_t s = 0; s < chain_.states(); ++s) {
      const ActionId action = tick(tree, chain_.features_of(s));
      const std::size_t column = action == kNoAction ? chain_.actions() : index_of(action);
      sum += gains_[s * (chain_.actions() + 1) + column];
    }
    return sum;
  }

  std::vector<Node> leaves() const {
    std::vector<Node> result;
    for (std::size_t a = 0; a < chain_.actions(); ++a) {
      result.push_back(Node::action(ActionId{static_cast<std::uint8_t>(a)}));
    }
    for (std::size_t f = 0; f < chain_.vocabulary().features.size(); ++f) {
      const Feature& feature = chain_.vocabulary().features[f];
      for (const std::uint8_t value : feature.values) {
        if (feature.admits_equal) {
          result.push_back(Node::condition(f, Op::equal, value));
        }
        if (feature.admits_less_equal && value != feature.values.back()) {
          result.push_back(Node::condition(f, Op::less_equal, value));
        }
      }
    }
    return result;
  }

  // Every tree that differs by one leaf, one branch of a condition and an action, one subtree that is missing, or two
  // siblings that have changed places: one by one, as a person would.
  std::vector<Tree> edited_by_hand(const Tree& tree) const {
    std::vector<TreeDraft> parts;
    for (const Node& leaf : leaves()) {
      parts.push_back({leaf});
      if (leaf.kind == NodeKind::condition) {
        for (std::size_t a = 0; a < chain_.actions(); ++a) {
          TreeDraft branch{Node::composite(NodeKind::sequence, 1)};
          branch.children = {{leaf}, {Node::action(ActionId{static_cast<std::uint8_t>(a)})}};
          parts.push_back(branch);
        }
      }
    }
    std::vector<Tree> result;
    const auto keep = [&](TreeDraft draft) {
      draft.tidy();
      if (auto finished = draft.finished()) {
        result.push_back(std::move(*finished));
      }
    };
    for (std::size_t node = 0; node < tree.size(); ++node) {
      const auto edit = [&](const auto& change) {
        TreeDraft draft = TreeDraft::of(tree.nodes());
        const auto places = draft.places();
        change(places[node]);
        keep(std::move(draft));
      };
      for (const TreeDraft& part : parts) {
        const bool leaf = part.children.empty();
        const std::size_t children = child_count(tree.subtree(node));
        if (leaf) {
          edit([&](const TreeDraft::Place& place) { *place.draft = part; });
        }
        for (std::size_t gap = 0; gap <= children && tree[node].is_composite(); ++gap) {
          if (leaf || tree[node].kind == NodeKind::selector) {
            edit([&](const TreeDraft::Place& place) { place.draft->insert(gap, part); });
          }
        }
      }
      if (node > 0 && child_count(tree.subtree(node)) + 1 > 0) {
        edit([&](const TreeDraft::Place& place) {
          if (place.parent->children.size() > 1) {
            place.parent->remove(place.index());
          }
        });
      }
      const std::size_t children = child_count(tree.subtree(node));
      for (std::size_t a = 0; a < children; ++a) {
        for (std::size_t b = a + 1; b < children; ++b) {
          edit([&](const TreeDraft::Place& place) { std::swap(place.draft->children[a], place.draft->children[b]); });
        }
      }
    }
    return result;
  }

  Chain chain_ = oracles::random_chain({.states = 150, .actions = 3, .seed = 5});
  std::vector<double> gains_;
  EditRanking ranking_{chain_};
};

TEST_F(EditRankingTest, promises_of_every_tree_what_ticking_it_in_every_state_gives) {
  for (const Tree& tree : oracles::random_trees(chain_.vocabulary(), 120, 11)) {
    const auto edits = ranking_.best(tree, gains_, {}, 40);
    for (const RankedEdit& edit : edits) {
      EXPECT_NEAR(edit.gain, ticked_gain(edit.tree), 1e-6);
    }
    EXPECT_TRUE(std::is_sorted(edits.begin(), edits.end(),
                               [](const RankedEdit& a, const RankedEdit& b) { return a.gain > b.gain; }));
  }
}

TEST_F(EditRankingTest, finds_nothing_worse_than_the_best_of_all_edits_made_by_hand) {
  for (const Tree& tree : oracles::random_trees(chain_.vocabulary(), 60, 12)) {
    double best = -1e300;
    for (const Tree& edited : edited_by_hand(tree)) {
      best = edited == tree ? best : std::max(best, ticked_gain(edited));
    }
    const auto edits = ranking_.best(tree, gains_, {}, 5);
    ASSERT_FALSE(edits.empty());
    EXPECT_GE(edits.front().gain, best - 1e-6);
  }
}

TEST_F(EditRankingTest,
       promises_of_edits_of_two_conditions_what_ticking_gives_and_finds_the_best_of_those_made_by_hand) {
  std::vector<Node> conditions;
  std::vector<TreeDraft> actions;
  for (const Node& leaf : leaves()) {
    if (leaf.kind == NodeKind::condition) {
      conditions.push_back(leaf);
    } else {
      actions.push_back({leaf});
    }
  }
  const auto sequence = [](std::vector<TreeDraft> children) {
    return TreeDraft{Node::composite(NodeKind::sequence, 1), std::move(children)};
  };
  const auto selector = [](std::vector<TreeDraft> children) {
    return TreeDraft{Node::composite(NodeKind::selector, 1), std::move(children)};
  };
  // (sequence c d a), (sequence (selector c d) a) and (selector (sequence c a) (sequence d b) e).
  std::vector<TreeDraft> branches;
  std::vector<TreeDraft> lists;
  for (const Node& c : conditions) {
    for (const Node& d : conditions) {
      if (c.index == d.index) {
        continue;
      }
      for (const TreeDraft& a : actions) {
        branches.push_back(sequence({{c}, {d}, a}));
        branches.push_back(sequence({selector({{c}, {d}}), a}));
        for (const TreeDraft& b : actions) {
          for (const TreeDraft& e : actions) {
            lists.push_back(selector({sequence({{c}, a}), sequence({{d}, b}), e}));
          }
        }
      }
    }
  }
  std::size_t trees = 0;
  for (const Tree& tree : oracles::random_trees(chain_.vocabulary(), 60, 31)) {
    if (tree.size() > 9) {
      continue;
    }
    ++trees;
    double best = -1e300;
    const auto measure = [&](const auto& change) {
      TreeDraft draft = TreeDraft::of(tree.nodes());
      change(draft);
      draft.tidy();
      if (const auto finished = draft.finished(); finished && !(*finished == tree)) {
        best = std::max(best, ticked_gain(*finished));
      }
    };
    // At the root, and in the gaps of a root that is a selector.
    for (const TreeDraft& list : lists) {
      measure([&](TreeDraft& draft) { draft = list; });
    }
    for (const TreeDraft& branch : branches) {
      measure([&](TreeDraft& draft) { draft = branch; });
      const std::size_t gaps = tree[0].kind == NodeKind::selector ? child_count(tree.nodes()) + 1 : 0;
      for (std::size_t gap = 0; gap < gaps; ++gap) {
        measure([&](TreeDraft& draft) { draft.insert(gap, branch); });
      }
    }
    const auto edits = ranking_.best_of_two_conditions(tree, gains_, {}, 10);
    ASSERT_FALSE(edits.empty());
    EXPECT_GE(edits.front().gain, best - 1e-6);
    for (const RankedEdit& edit : edits) {
      EXPECT_NEAR(edit.gain, ticked_gain(edit.tree), 1e-6);
    }
  }
  EXPECT_GE(trees, 5U);
}

TEST_F(EditRankingTest, keeps_within_the_limits) {
  for (const Tree& tree : oracles::random_trees(chain_.vocabulary(), 60, 13)) {
    const EditLimits limits{.max_nodes = tree.size(), .max_conditions = condition_count(tree.nodes())};
    for (const RankedEdit& edit : ranking_.best(tree, gains_, limits, 30)) {
      EXPECT_LE(edit.tree.size(), limits.max_nodes);
      EXPECT_LE(condition_count(edit.tree.nodes()), limits.max_conditions);
      EXPECT_NE(edit.tree, tree);
    }
  }
}

TEST_F(EditRankingTest, keeps_a_guarded_tree_guarded) {
  Xoshiro256 random(17);
  for (int i = 0; i < 40; ++i) {
    const Tree tree = grow_guarded_tree(chain_.vocabulary(), {.max_depth = 6, .max_children = 5, .max_nodes = 30},
                                        [&](std::uint64_t n) { return random.below(n); });
    ASSERT_TRUE(is_guarded(tree));
    auto edits = ranking_.best(tree, gains_, {.guarded = true}, 60);
    for (RankedEdit& edit : ranking_.best_of_two_conditions(tree, gains_, {.guarded = true}, 30)) {
      for (RankedEdit& next : ranking_.best(edit.tree, gains_, {.guarded = true}, 20)) {  // its (selector c d), too
        edits.push_back(std::move(next));
      }
      edits.push_back(std::move(edit));
    }
    for (const RankedEdit& edit : edits) {
      EXPECT_TRUE(is_guarded(edit.tree));
      EXPECT_NEAR(edit.gain, ticked_gain(edit.tree), 1e-6);
    }
  }
}

}  // namespace
}  // namespace coppice
