#include "coordinator/learning/simulate.hpp"

#include <gtest/gtest.h>
#include <set>

#include "common/chain/random.hpp"
#include "coordinator/learning/learn.hpp"
#include "coordinator/learning/uav_room.hpp"
#include "tests/coordinator/learning/rooms.hpp"

namespace coppice {
namespace {

bool operator==(const EpisodeRecord& a, const EpisodeRecord& b) {
  return a.reward == b.reward && a.steps == b.steps && a.matches == b.matches && a.collisions == b.collisions &&
         a.unknown == b.unknown;
}

Chain learned_chain(const World& world, std::uint64_t episodes, std::uint32_t steps) {
  LearnSettings settings = default_settings(world.kind, Algorithm::q_learning);
  settings.episodes = episodes;
  settings.steps = steps;
  return std::move(learn(world, settings, {})->chain);
}

// The policy written out as a tree: a selector with one sequence of conditions and an action for each state.
Tree spelled_out(const Chain& chain) {
  std::vector<Node> nodes;
  for (std::size_t state = 0; state < chain.states(); ++state) {
    const auto features = chain.features_of(state);
    nodes.push_back(Node::composite(NodeKind::sequence, features.size() + 2));
    for (std::size_t f = 0; f < features.size(); ++f) {
      nodes.push_back(Node::condition(f, Op::equal, features[f]));
    }
    nodes.push_back(Node::action(chain.policy(state)));
  }
  nodes.insert(nodes.begin(), Node::composite(NodeKind::selector, nodes.size() + 1));
  return Tree::from_nodes(std::move(nodes)).value();
}

World tiny_room() { return testing::world({"#####", "#.*.#", "#.^.#", "#####"}); }

TEST(Simulate, ATreeThatSpellsThePolicyOutDoesWhatThePolicyDoes) {
  const World windy = load_world("windy").value();
  for (const World& world : {windy, tiny_room()}) {
    const Chain chain = learned_chain(world, 3000, 25);
    const Tree tree = spelled_out(chain);
    const SimulateSettings settings{.episodes = 30, .steps = 40, .seed = 5};
    const auto by_policy = simulate_policy(world, chain, settings).value();
    const auto by_tree = simulate_tree(world, chain, tree, settings).value();
    ASSERT_EQ(by_policy.size(), 30U);
    ASSERT_EQ(by_tree.size(), 30U);
    for (std::size_t i = 0; i < by_policy.size(); ++i) {
      EXPECT_TRUE(by_policy[i] == by_tree[i]) << "episode " << i;
      EXPECT_EQ(by_policy[i].matches, by_policy[i].steps);
      EXPECT_EQ(by_policy[i].unknown, 0U);
    }
  }
}

TEST(Simulate, AnEpisodesLuckIsItsOwn) {
  const World world = testing::world(testing::small_room());
  const Chain chain = learned_chain(world, 500, 60);
  const auto few = simulate_policy(world, chain, {.episodes = 5, .steps = 60, .seed = 3}).value();
  const auto many = simulate_policy(world, chain, {.episodes = 40, .steps = 60, .seed = 3}).value();
  std::set<double> rewards;
  for (std::size_t i = 0; i < many.size(); ++i) {
    rewards.insert(many[i].reward);
    if (i < few.size()) {
      EXPECT_TRUE(few[i] == many[i]) << "episode " << i;
    }
  }
  EXPECT_GT(rewards.size(), 5U);
  const auto other = simulate_policy(world, chain, {.episodes = 40, .steps = 60, .seed = 4}).value();
  bool differs = false;
  for (std::size_t i = 0; i < many.size(); ++i) {
    differs = differs || !(other[i] == many[i]);
  }
  EXPECT_TRUE(differs);
}

TEST(Simulate, WithoutAnActionTheAgentHoldsStill) {
  const World world = tiny_room();
  const Chain chain = learned_chain(world, 100, 25);
  const Tree tree = Tree::from_nodes({Node::condition(3, Op::equal, 3)}).value();
  const auto records = simulate_tree(world, chain, tree, {.episodes = 3, .steps = 12, .seed = 1}).value();
  for (const EpisodeRecord& record : records) {
    EXPECT_EQ(record.steps, 12U);
    EXPECT_EQ(record.reward, 0.0);
    EXPECT_EQ(record.matches, 0U);
    EXPECT_EQ(record.collisions, 0U);
    EXPECT_EQ(record.unknown, 0U);
  }
}

TEST(Simulate, AGoalEndsTheEpisodeAndAStepLimitToo) {
  const World world = load_world("windy").value();
  const Chain chain = learned_chain(world, 2000, 25);
  EXPECT_EQ((*simulate_policy(world, chain, {.episodes = 1, .steps = 1000, .seed = 1}))[0].steps, 15U);
  EXPECT_EQ((*simulate_policy(world, chain, {.episodes = 1, .steps = 10, .seed = 1}))[0].steps, 10U);
  const auto always_up =
      simulate_tree(world, chain, Tree(ActionId{0}), {.episodes = 1, .steps = 30, .seed = 1}).value();
  EXPECT_EQ(always_up[0].steps, 30U);
  EXPECT_EQ(always_up[0].reward, -30.0);
}

TEST(Simulate, CollisionsAndMatchesAreCountedStepByStep) {
  const World world = testing::world({"####", "#^.#", "#..#", "####"});
  const Chain chain = learned_chain(world, 200, 25);
  const auto move = simulate_tree(world, chain, Tree(ActionId{0}), {.episodes = 2, .steps = 7, .seed = 1}).value();
  EXPECT_EQ(move[1].collisions, 7U);
  EXPECT_EQ(move[1].reward, -70.0);
  EXPECT_EQ(move[1].matches, 0U) << "the policy does not move into a wall";
}

TEST(Simulate, StopsBetweenEpisodesWhenToldTo) {
  const World world = testing::world(testing::small_room());
  const Chain chain = learned_chain(world, 1, 3);
  int asked = 0;
  const auto records =
      simulate_policy(world, chain, {.episodes = 9, .steps = 5, .seed = 1}, [&] { return ++asked < 4; });
  ASSERT_FALSE(records);
  EXPECT_EQ(records.error().kind, ErrorKind::interrupted);
  EXPECT_EQ(asked, 4);
}

// Against a walk made here, step by step, in the same simulator with the same stream.
TEST(Simulate, StatesThatTheChainDoesNotKnowAreCountedAndNeverMatch) {
  const World world = testing::world(testing::small_room());
  const Chain chain = learned_chain(world, 1, 3);
  std::set<std::uint32_t> known;
  for (std::size_t state = 0; state < chain.states(); ++state) {
    known.insert(UavRoom::code_of(chain.features_of(state)));
  }
  const auto records = simulate_policy(world, chain, {.episodes = 4, .steps = 30, .seed = 9}).value();
  std::uint32_t unknown_in_all = 0;
  for (std::uint32_t episode = 0; episode < 4; ++episode) {
    UavRoom room(testing::room(testing::small_room()));
    Stream random(9, Purpose::simulating, 0, episode);
    std::uint32_t unknown = 0;
    double reward = 0.0;
    for (int step = 0; step < 30; ++step) {
      std::uint32_t action = 0;
      unknown += known.count(room.code()) == 0 ? 1 : 0;
      for (std::size_t state = 0; state < chain.states(); ++state) {
        if (UavRoom::code_of(chain.features_of(state)) == room.code()) {
          action = static_cast<std::uint32_t>(index_of(chain.policy(state)));
        }
      }
      reward += room.step(action, random).reward;
    }
    EXPECT_EQ(records[episode].unknown, unknown);
    EXPECT_EQ(records[episode].matches, 30 - unknown);
    EXPECT_EQ(records[episode].reward, reward);
    unknown_in_all += unknown;
  }
  EXPECT_GT(unknown_in_all, 0U);
}

}  // namespace
}  // namespace coppice
