// evaluate() against a walk written as plainly as can be, and against chains whose answers are known.
#include "common/fitness/evaluation.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <optional>
#include <string>

#include "common/tree/tick.hpp"
#include "tests/common/fitness/evaluate_once.hpp"
#include "tests/oracles/chains.hpp"
#include "tests/oracles/trees.hpp"

namespace coppice {
namespace {

std::vector<Objective> all_objectives(const Vocabulary& vocabulary) {
  const ShapedRule trash{{Node::condition(0, Op::equal, 3), Node::condition(1, Op::equal, 3)}, 8, -4};
  const ShapedRule wall{{Node::condition(5, Op::less_equal, 1)}, 1, -2};
  EXPECT_GE(vocabulary.features.size(), 6U);
  return {
      {ObjectiveKind::agreement, {}}, {ObjectiveKind::q_value, {}}, {ObjectiveKind::shaped, {trash, wall, {{}, 1, 0}}},
      {ObjectiveKind::coverage, {}},  {ObjectiveKind::visits, {}},  {ObjectiveKind::expected_return, {}},
      {ObjectiveKind::regret, {}},    {ObjectiveKind::seen, {}, 3}, {ObjectiveKind::collisions, {}, -0.25},
      {ObjectiveKind::unknown, {}}};
}

// The reference: tick at every step, search the row of successors linearly, one walk at a time.
Tally plain_evaluation(const Chain& chain, const Job& job, const std::vector<Objective>& objectives, const Tree& tree) {
  Tally tally;
  tally.nodes = static_cast<std::uint32_t>(tree.size());
  tally.scores.assign(objectives.size(), 0);
  const AliasRows rows(chain);
  std::vector<ScoreTable> tables;
  for (const Objective& objective : objectives) {
    tables.push_back(*make_score_table(chain, objective));
  }
  const auto score = [&](std::size_t state, ActionId action, bool walking) {
    const std::size_t column = action == kNoAction ? chain.actions() : index_of(action);
    for (std::size_t i = 0; i < objectives.size(); ++i) {
      if (along_walk(objectives[i].kind) == walking) {
        tally.scores[i] += tables[i].scores[state * (chain.actions() + 1) + column];
      }
    }
  };
  for (std::uint32_t rollout = 0; rollout < job.rollouts; ++rollout) {
    std::uint32_t state = chain.initial_state();
    for (std::uint32_t step = 0; step < job.steps; ++step) {
      const ActionId action = tick(tree, chain.features_of(state));
      tally.matches += action == chain.policy(state) ? 1 : 0;
      ++tally.steps;
      score(state, action, true);
      const bool policy_acts = job.acting == Acting::policy ||
                               (job.acting == Acting::mixed &&
                                draw({job.seed, Purpose::mixing, job.generation, rollout, step}) < job.policy_share);
      const ActionId acting = policy_acts ? chain.policy(state) : action;
      const std::size_t column = acting == kNoAction ? chain.actions() : index_of(acting);
      std::vector<std::uint32_t> words(step + 1);
      draw_words({job.seed, Purpose::rollout, job.generation, rollout, 0}, words);
      state = rows.sample_carefully(rows.row(state, column), words[step], [&](std::uint32_t attempt) {
        return draw({job.seed ^ (std::uint64_t{attempt} << 32U), Purpose::redraw, job.generation, rollout, step});
      });
    }
  }
  for (std::size_t state = 0; state < chain.states(); ++state) {
    score(state, tick(tree, chain.features_of(state)), false);
  }
  return tally;
}

// Every way to compute a tally: with vectors and without, with tables and lazily.
struct Way {
  PreparedChain::Form form;
  Simd simd;
};
std::vector<Way> all_ways() {
  std::vector<Way> ways = {{PreparedChain::Form::tables, Simd::none}, {PreparedChain::Form::lazy, Simd::none}};
  if (best_simd() != Simd::none) {
    ways.push_back({PreparedChain::Form::tables, best_simd()});
    ways.push_back({PreparedChain::Form::lazy, best_simd()});
  }
  return ways;
}

TEST(Evaluation, EqualsThePlainWalkInEveryWayForEveryActingPolicyAndNumberOfRollouts) {
  const auto chain = oracles::shared_random_chain({.states = 300, .actions = 3, .seed = 31});
  const auto trees = oracles::random_trees(chain->vocabulary(), 40, 3);
  for (const Acting acting : {Acting::tree, Acting::policy, Acting::mixed}) {
    for (const std::uint32_t rollouts : {1U, 2U, 5U, 7U, 8U, 16U, 19U, 32U, 45U}) {
      Job job;
      job.objectives = all_objectives(chain->vocabulary());
      job.rollouts = rollouts;
      job.steps = 37;
      job.acting = acting;
      job.policy_share = std::uint64_t{1} << 62U;
      job.seed = 99;
      job.generation = rollouts;
      std::vector<Tally> expected;
      for (const Tree& tree : trees) {
        expected.push_back(plain_evaluation(*chain, job, job.objectives, tree));
      }
      for (const Way& way : all_ways()) {
        Evaluation evaluation(*PreparedJob::make(PreparedChain::make(chain, way.form), job), way.simd);
        ASSERT_EQ(evaluation.evaluate(trees), expected);  // many to a pass
        for (std::size_t i = 0; i < trees.size(); i += 7) {
          Evaluation alone(*PreparedJob::make(PreparedChain::make(chain, way.form), job), way.simd);
          ASSERT_EQ(alone.evaluate(trees[i]), expected[i]);
        }
      }
    }
  }
}

TEST(Evaluation, WithoutAPathEqualsThePlainWalkInEveryWay) {
  const auto chain = oracles::shared_random_chain({.states = 513, .actions = 7, .seed = 77});
  const auto trees = oracles::random_trees(chain->vocabulary(), 60, 8);
  for (const Acting acting : {Acting::tree, Acting::mixed}) {
    Job job;
    job.rollouts = 3;
    job.steps = 200;
    job.acting = acting;
    job.policy_share = std::uint64_t{3} << 62U;
    std::vector<Tally> expected;
    for (const Tree& tree : trees) {
      expected.push_back(plain_evaluation(*chain, job, job.objectives, tree));
    }
    for (const Way& way : all_ways()) {
      Evaluation evaluation(*PreparedJob::make(PreparedChain::make(chain, way.form), job), way.simd);
      ASSERT_EQ(evaluation.evaluate(trees), expected);
    }
  }
}

// Many steps whose random bits do not decide alone: a row of 60000 bins leaves one in 36000 open.
TEST(Evaluation, EqualsThePlainWalkWhereBitsAreShort) {
  ChainParts parts = oracles::random_chain({.states = 700, .actions = 1, .seed = 3}).parts();
  constexpr std::uint32_t kStates = 60'000;
  const std::size_t features = 16;
  parts.vocabulary.features.clear();
  parts.features.clear();
  for (std::size_t bit = 0; bit < features; ++bit) {
    parts.vocabulary.features.push_back({"b" + std::to_string(bit), {0, 1}});
  }
  for (std::uint32_t state = 0; state < kStates; ++state) {
    for (std::size_t bit = 0; bit < features; ++bit) {
      parts.features.push_back(static_cast<std::uint8_t>(state >> bit & 1U));
    }
  }
  parts.row_begin.assign(kStates + 1, 0);  // nothing was ever tried: every step leads anywhere
  parts.successor.clear();
  parts.count.clear();
  parts.reward_sum.assign(kStates, 0.0);
  parts.q.assign(kStates, 0.0);
  parts.policy.assign(kStates, ActionId{0});
  parts.visits.assign(kStates, 1);
  parts.initial_state = 5;
  auto made = Chain::make(std::move(parts));
  ASSERT_TRUE(made.has_value()) << made.error().message;
  const auto chain = std::make_shared<const Chain>(std::move(*made));
  Job job;
  job.rollouts = 40;
  job.steps = 5000;
  std::optional<Tally> first;
  for (const Way& way : all_ways()) {
    Evaluation evaluation(*PreparedJob::make(PreparedChain::make(chain, way.form), job), way.simd);
    const Tally tally = evaluation.evaluate(Tree(ActionId{0}));
    EXPECT_EQ(tally, first.value_or(tally));
    first = tally;
  }
}

TEST(Evaluation, WalksTreesThatMeanTheSameOnce) {
  const auto chain = oracles::shared_random_chain({.states = 200, .seed = 6});
  const Tree move(ActionId{1});
  const auto wrapped = Tree::from_nodes(
      {Node::composite(NodeKind::selector, 3), Node::composite(NodeKind::sequence, 2), Node::action(ActionId{1})});
  Evaluation evaluation(*PreparedJob::make(PreparedChain::make(chain), Job{}));
  const std::vector<Tally> tallies = evaluation.evaluate(std::vector<Tree>{move, Tree(ActionId{0}), *wrapped, move});
  EXPECT_EQ(evaluation.repeated(), 2U);
  EXPECT_EQ(tallies[2].nodes, 3U);
  EXPECT_EQ(tallies[2].matches, tallies[0].matches);
  EXPECT_EQ(tallies[3], tallies[0]);
  EXPECT_NE(tallies[1], tallies[0]);
  evaluation.evaluate(move);
  EXPECT_EQ(evaluation.repeated(), 3U);  // also from call to call
}

TEST(Evaluation, DependsOnTheSeedAndTheGeneration) {
  const auto prepared = prepare(oracles::random_chain({.states = 300, .seed = 8}));
  const Tree tree = oracles::random_trees(prepared->chain().vocabulary(), 9, 5).back();
  Job job;
  job.seed = 1;
  const Tally first = evaluate(prepared, job, tree);
  EXPECT_EQ(first, evaluate(prepared, job, tree));
  int different = 0;
  for (std::uint32_t generation = 1; generation <= 5; ++generation) {
    job.generation = generation;
    different += evaluate(prepared, job, tree).matches == first.matches ? 0 : 1;
  }
  EXPECT_GE(different, 2);
}

TEST(Evaluation, IsTheSameForTreesThatMeanTheSame) {
  const auto prepared = prepare(oracles::random_chain({.states = 200, .seed = 6}));
  Job job;
  const Tree move(ActionId{1});
  const auto wrapped = Tree::from_nodes(
      {Node::composite(NodeKind::selector, 3), Node::composite(NodeKind::sequence, 2), Node::action(ActionId{1})});
  ASSERT_TRUE(wrapped.has_value());
  EXPECT_EQ(evaluate(prepared, job, move).matches, evaluate(prepared, job, *wrapped).matches);
}

TEST(Evaluation, GoesOnWithAnotherJobAsIfMadeAnew) {
  const auto chain = oracles::shared_random_chain({.states = 300, .actions = 3, .seed = 31});
  const auto trees = oracles::random_trees(chain->vocabulary(), 20, 3);
  const auto prepared = PreparedChain::make(chain);
  Evaluation reused(*PreparedJob::make(prepared, Job{}));
  reused.evaluate(trees);
  for (const std::uint32_t rollouts : {40U, 3U, 9U}) {
    for (const Method method : {Method::rollouts, Method::exact}) {
      Job job;
      job.rollouts = rollouts;
      job.method = method;
      job.acting = rollouts == 3 ? Acting::mixed : Acting::tree;
      job.policy_share = std::uint64_t{1} << 63U;
      job.objectives = rollouts == 9 ? std::vector<Objective>(1) : all_objectives(chain->vocabulary());
      const auto prepared_job = *PreparedJob::make(prepared, job);
      reused.begin(prepared_job);
      ASSERT_EQ(reused.evaluate(trees), Evaluation(prepared_job).evaluate(trees));
    }
  }
}

TEST(Meanings, AreToldApartByActionTables) {
  const auto chain = oracles::shared_random_chain({.states = 200, .seed = 6});
  const auto wrapped = Tree::from_nodes(
      {Node::composite(NodeKind::selector, 3), Node::composite(NodeKind::sequence, 2), Node::action(ActionId{1})});
  Meanings meanings(*chain);
  EXPECT_EQ(meanings.of(*wrapped), meanings.of(Tree(ActionId{1})));
  EXPECT_NE(meanings.of(*wrapped), meanings.of(Tree(ActionId{0})));
}

TEST(Evaluation, WithoutAnActionHoldsTheStateAndNeverAgrees) {
  const auto prepared = prepare(oracles::random_chain({.states = 200, .seed = 6}));
  const Node never = Node::condition(0, Op::equal, 0);
  const Node also = Node::condition(0, Op::equal, 1);
  const auto tree = Tree::from_nodes({Node::composite(NodeKind::sequence, 4), never, also, Node::action(ActionId{0})});
  Job job;
  job.objectives = {
      {ObjectiveKind::agreement, {}}, {ObjectiveKind::expected_return, {}}, {ObjectiveKind::coverage, {}}};
  const Tally tally = evaluate(prepared, job, *tree);
  EXPECT_EQ(tally.matches, 0U);
  EXPECT_EQ(tally.scores, (std::vector<std::int64_t>{0, 0, 0}));
}

// Walks of one step: where they start is all that there is. Within 5 standard errors.
TEST(ClosedForm, StartsAreDrawnAsOftenAsTheyAreAskedFor) {
  const Chain chain = oracles::random_chain({.states = 60, .seed = 12});
  const auto prepared = prepare(chain);
  const ActionId action = chain.policy(chain.initial_state());
  const Tree tree(action);
  Job job;
  job.rollouts = 40'000;
  job.steps = 1;
  double states = 0.0;
  double visits = 0.0;
  double all_visits = 0.0;
  for (std::size_t s = 0; s < chain.states(); ++s) {
    const bool agrees = chain.policy(s) == action;
    states += agrees ? 1.0 : 0.0;
    visits += agrees ? static_cast<double>(chain.parts().visits[s]) : 0.0;
    all_visits += static_cast<double>(chain.parts().visits[s]);
  }
  const auto expect_share = [&](Start start, double share) {
    job.start = start;
    const Tally tally = evaluate(prepared, job, tree);
    const double error = std::sqrt(share * (1.0 - share) / job.rollouts);
    EXPECT_NEAR(static_cast<double>(tally.matches) / job.rollouts, share, 5 * error) << name_of(start);
    const auto lazy =
        PreparedJob::make(PreparedChain::make(std::make_shared<const Chain>(chain), PreparedChain::Form::lazy), job);
    EXPECT_EQ(Evaluation(*lazy).evaluate(tree), tally) << name_of(start) << ": without tables";
    EXPECT_EQ(Evaluation(*PreparedJob::make(prepared, job), Simd::none).evaluate(tree), tally);
  };
  expect_share(Start::initial, 1.0);
  expect_share(Start::uniform, states / static_cast<double>(chain.states()));
  expect_share(Start::visits, visits / all_visits);
}

// Mean of a Bernoulli or bounded quantity over n independent walks: within 5 standard errors.
TEST(ClosedForm, KnuthsDieIsFairAndTakesElevenThirdsFlips) {
  const auto prepared = prepare(oracles::knuth_die());
  const Tree flip(ActionId{0});
  Job job;
  job.objectives = {{ObjectiveKind::expected_return, {}}};  // 1 a flip
  job.rollouts = 40'000;
  job.steps = 200;  // all but 2^-100 of the walks are over
  const Tally tally = evaluate(prepared, job, flip);
  const double flips = static_cast<double>(tally.scores[0]) / kScoreOne / job.rollouts;
  // Variance of the number of flips: 3 + 2 G flips with P(another round) = 1/4, so 4 x (1/4) / (3/4)^2 = 16/9.
  EXPECT_NEAR(flips, 11.0 / 3.0, 5 * std::sqrt(16.0 / 9.0 / job.rollouts));
}

TEST(ClosedForm, KnuthsDieShowsEveryFaceEquallyOften) {
  // Faces are told apart by shaped rules: 1 for the steps spent in face f after all walks are over.
  const Chain chain = oracles::knuth_die();
  const auto prepared = prepare(chain);
  Job job;
  job.rollouts = 20'000;
  job.steps = 60;
  for (std::uint32_t face = 7; face < 13; ++face) {
    // Wrong weights pick the states that differ from the face in a bit; what is left is the face itself.
    ShapedRule others{{}, 0, 0};
    for (std::uint8_t bit = 0; bit < 4; ++bit) {
      others.any_of.push_back(Node::condition(bit, Op::equal, static_cast<std::uint8_t>(1U - (face >> bit & 1U))));
    }
    job.objectives = {{ObjectiveKind::shaped, {others, {{}, 1, 1}}}};
    const Tally tally = evaluate(prepared, job, Tree(ActionId{0}));
    // A walk that ends in the face spends steps - flips there: 60 - (flips to this face), whose mean is below 60 - 3.
    const double share = static_cast<double>(tally.scores[0]) / job.rollouts / (job.steps - 11.0 / 3.0);
    EXPECT_NEAR(share, 1.0 / 6.0, 5 * std::sqrt(5.0 / 36.0 / job.rollouts) + 0.002) << "face " << face - 6;
  }
}

TEST(ClosedForm, TheGamblerIsRuinedAsOftenAsTheFormulaSays) {
  for (const auto& [wins, losses] : {std::pair{9U, 10U}, {10U, 9U}, {1U, 2U}}) {
    const oracles::Gambler gambler{.fortune = 4, .goal = 10, .wins = wins, .losses = losses};
    const auto prepared = prepare(oracles::gamblers_ruin(gambler));
    Job job;
    job.objectives = {{ObjectiveKind::expected_return, {}}};
    job.rollouts = 12'000;
    job.steps = 1000;  // P(still playing) is below 1e-9
    const Tally tally = evaluate(prepared, job, Tree(ActionId{0}));
    // The recorded reward is the row's mean: wins / (wins + losses) in the state next to the goal, on every bet there,
    // which in expectation is 1 for every arrival.
    const double r = static_cast<double>(losses) / wins;
    const double expected = (1 - std::pow(r, gambler.fortune)) / (1 - std::pow(r, gambler.goal));
    const double mean = static_cast<double>(tally.scores[0]) / kScoreOne / job.rollouts;
    EXPECT_NEAR(mean, expected, 5 * std::sqrt(0.5 / job.rollouts)) << wins << ":" << losses;
  }
}

TEST(PreparedJob, RefusesWhatDoesNotFit) {
  const auto prepared = prepare(oracles::knuth_die());
  Job job;
  job.objectives = {{ObjectiveKind::shaped, {}}};
  EXPECT_FALSE(PreparedJob::make(prepared, job).has_value());
  job.objectives = {{ObjectiveKind::shaped, {{{Node::condition(9, Op::equal, 0)}, 1, 0}}}};
  EXPECT_FALSE(PreparedJob::make(prepared, job).has_value());
  job = {};
  job.rollouts = 0;
  EXPECT_FALSE(PreparedJob::make(prepared, job).has_value());
  job = {};
  job.rollouts = kMaxRollouts;
  job.steps = kMaxSteps;
  EXPECT_FALSE(PreparedJob::make(prepared, job).has_value());
}

TEST(Objective, NamesGoBothWays) {
  for (std::uint8_t kind = 0; kind < kObjectiveKinds; ++kind) {
    EXPECT_EQ(*value_named<ObjectiveKind>("objective", name_of(static_cast<ObjectiveKind>(kind))),
              static_cast<ObjectiveKind>(kind));
  }
  EXPECT_FALSE(value_named<ObjectiveKind>("objective", "agreemnt").has_value());
}

}  // namespace
}  // namespace coppice
