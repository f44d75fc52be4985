// Expected values as tallies: against the occupancy they come from, against roll-outs within their confidence, and for
// what a tally promises.
#include "common/fitness/exact_evaluation.hpp"

#include <cmath>
#include <gtest/gtest.h>

#include "common/fitness/evaluation.hpp"
#include "tests/common/fitness/evaluate_once.hpp"
#include "tests/oracles/chains.hpp"
#include "tests/oracles/trees.hpp"

namespace coppice {
namespace {

Job job_of(Method method, std::uint32_t steps = 100) {
  Job job;
  job.objectives = {{ObjectiveKind::agreement, {}},
                    {ObjectiveKind::q_value, {}},
                    {ObjectiveKind::shaped, {{{Node::condition(0, Op::equal, 3)}, 8, -4}, {{}, 1, 0}}},
                    {ObjectiveKind::coverage, {}},
                    {ObjectiveKind::visits, {}},
                    {ObjectiveKind::expected_return, {}}};
  job.method = method;
  job.steps = steps;
  job.gamma = method == Method::discounted ? fixed_point_share(0.95) : 0;
  return job;
}

double per_step(const Tally& tally, std::size_t objective) {
  return static_cast<double>(tally.scores[objective]) / static_cast<double>(tally.steps);
}

TEST(ExactEvaluation, RolloutMeansConvergeToIt) {
  // Means of one walk's sum over n independent walks: within 5 standard errors, the deviation estimated from 200
  // groups.
  constexpr std::uint32_t kGroups = 200;
  for (const Acting acting : {Acting::tree, Acting::policy, Acting::mixed}) {
    const auto chain = prepare(oracles::random_chain({.states = 200, .actions = 3, .seed = 5}));
    const auto trees = oracles::random_trees(chain->chain().vocabulary(), 12, 9);
    for (const Tree& tree : trees) {
      Job job = job_of(Method::exact, 30);
      job.acting = acting;
      job.policy_share = acting == Acting::mixed ? std::uint64_t{1} << 62U : 0;
      const Tally exact = evaluate(chain, job, tree);
      job.method = Method::rollouts;
      job.rollouts = 100;
      std::vector<double> sum(job.objectives.size(), 0.0);
      std::vector<double> squares(job.objectives.size(), 0.0);
      for (job.generation = 0; job.generation < kGroups; ++job.generation) {
        const Tally walked = evaluate(chain, job, tree);
        for (std::size_t o = 0; o < sum.size(); ++o) {
          sum[o] += per_step(walked, o);
          squares[o] += per_step(walked, o) * per_step(walked, o);
        }
      }
      for (const std::size_t o : {0U, 1U, 2U, 5U}) {
        const double mean = sum[o] / kGroups;
        const double variance = std::max(0.0, squares[o] / kGroups - mean * mean) / (kGroups - 1);
        const double rounding = 1e-6 * (1.0 + std::abs(mean));
        EXPECT_NEAR(mean, per_step(exact, o), 5.0 * std::sqrt(variance) + rounding) << "objective " << o;
      }
    }
  }
}

TEST(ExactEvaluation, ATallyReadsLikeThatManySteps) {
  const auto chain = prepare(oracles::random_chain({.states = 200, .seed = 6}));
  for (const Tree& tree : oracles::random_trees(chain->chain().vocabulary(), 60, 2)) {
    const Tally over_states = evaluate(chain, job_of(Method::rollouts), tree);
    for (const Method method : {Method::exact, Method::discounted, Method::long_run}) {
      for (const std::uint32_t steps : {1U, 100U, 4096U}) {
        const Job job = job_of(method, steps);
        const Tally tally = evaluate(chain, job, tree);
        EXPECT_EQ(tally.nodes, tree.size());
        EXPECT_LE(tally.matches, tally.steps);
        EXPECT_GT(2 * tally.steps, kMaxWalkedSteps);
        EXPECT_LE(tally.steps, kMaxWalkedSteps);
        EXPECT_EQ(tally.steps % (method == Method::exact ? steps : kMaxWalkedSteps), 0U);
        EXPECT_EQ(tally.scores[0], static_cast<std::int64_t>(tally.matches));
        EXPECT_EQ(tally.scores[3], over_states.scores[3]);
        EXPECT_EQ(tally.scores[4], over_states.scores[4]);
      }
    }
  }
}

TEST(ExactEvaluation, APolicyThatActsAndIsCopiedAgreesInEveryStep) {
  // One action only: the tree is the policy, so matches are all steps, to the last.
  const auto chain = prepare(oracles::gamblers_ruin({}));
  for (const Method method : {Method::exact, Method::discounted, Method::long_run}) {
    Job job;
    job.method = method;
    job.gamma = method == Method::discounted ? fixed_point_share(0.999) : 0;
    const Tally tally = evaluate(chain, job, Tree(ActionId{0}));
    EXPECT_EQ(tally.matches, tally.steps) << name_of(method);
  }
}

TEST(ExactEvaluation, KnuthsDieTakesElevenThirdsFlips) {
  const auto chain = prepare(oracles::knuth_die());
  Job job;
  job.objectives = {{ObjectiveKind::expected_return, {}}};  // 1 a flip
  job.method = Method::exact;
  job.steps = 64;
  const Tally tally = evaluate(chain, job, Tree(ActionId{0}));
  EXPECT_EQ(tally.steps, kMaxWalkedSteps);
  EXPECT_NEAR(per_step(tally, 0) / kScoreOne * 64, 11.0 / 3.0, 1e-9);
}

TEST(ExactEvaluation, DependsOnNeitherSeedNorGenerationNorNumberOfRollouts) {
  const auto chain = prepare(oracles::random_chain({.states = 100, .seed = 6}));
  const Tree tree = oracles::random_trees(chain->chain().vocabulary(), 3, 5).back();
  for (const Method method : {Method::exact, Method::discounted, Method::long_run}) {
    Job job = job_of(method);
    const Tally tally = evaluate(chain, job, tree);
    job.seed = 5;
    job.generation = 8;
    job.rollouts = 77;
    EXPECT_EQ(evaluate(chain, job, tree), tally);
  }
}

TEST(ExactEvaluation, WithoutAnActionHoldsTheStateAndNeverAgrees) {
  const auto chain = prepare(oracles::random_chain({.states = 200, .seed = 6}));
  const auto never = Tree::from_nodes({Node::composite(NodeKind::sequence, 4), Node::condition(0, Op::equal, 0),
                                       Node::condition(0, Op::equal, 1), Node::action(ActionId{0})});
  ASSERT_TRUE(never.has_value());
  for (const Method method : {Method::exact, Method::discounted, Method::long_run}) {
    const Tally tally = evaluate(chain, job_of(method), *never);
    EXPECT_EQ(tally.matches, 0U);
    EXPECT_EQ(tally.scores[1], 0);
    EXPECT_EQ(tally.scores[5], 0);
    EXPECT_GT(tally.steps, 0U);
  }
}

TEST(ExactEvaluation, ThePolicyThatActsIsSolvedOnceForAllTrees) {
  const auto chain = prepare(oracles::random_chain({.states = 150, .seed = 12}));
  const auto trees = oracles::random_trees(chain->chain().vocabulary(), 20, 3);
  for (const Method method : {Method::exact, Method::discounted, Method::long_run}) {
    Job job = job_of(method);
    job.acting = Acting::policy;
    auto prepared = PreparedJob::make(chain, job);
    ASSERT_TRUE(prepared.has_value());
    Evaluation one(*prepared);
    for (const Tree& tree : trees) {
      EXPECT_EQ(one.evaluate(tree), evaluate(chain, job, tree));
    }
  }
}

TEST(ExactEvaluation, WhatIsRememberedIsWhatWouldBeComputed) {
  const auto chain = prepare(oracles::random_chain({.states = 150, .seed = 13}));
  const auto trees = oracles::random_trees(chain->chain().vocabulary(), 40, 8);
  for (const Method method : {Method::exact, Method::discounted, Method::long_run}) {
    auto prepared = PreparedJob::make(chain, job_of(method));
    ASSERT_TRUE(prepared.has_value());
    Evaluation lasting(*prepared);
    std::vector<Tally> first;
    for (const Tree& tree : trees) {
      first.push_back(lasting.evaluate(tree));
    }
    for (std::size_t i = 0; i < trees.size(); ++i) {
      EXPECT_EQ(lasting.evaluate(trees[i]), first[i]);
      EXPECT_EQ(evaluate(chain, job_of(method), trees[i]), first[i]);
    }
  }
}

TEST(CheckJob, GammaBelongsToTheDiscountedMethod) {
  Job job;
  job.gamma = 1;
  EXPECT_FALSE(check_job(job).has_value());
  job.method = Method::discounted;
  EXPECT_TRUE(check_job(job).has_value());
  job.gamma = fixed_point_share(kMaxGamma);
  EXPECT_TRUE(check_job(job).has_value());
  job.gamma = fixed_point_share(1.0);
  const auto refused = check_job(job);
  ASSERT_FALSE(refused.has_value());
  EXPECT_NE(refused.error().message.find("gamma is 1"), std::string::npos) << refused.error().message;
}

TEST(CheckJob, TooLargeAChainIsNotSolvedButWalked) {
  Job job;
  for (const Method method : {Method::discounted, Method::long_run}) {
    job.method = method;
    EXPECT_TRUE(check_solvable(job, kMaxSolvedStates).has_value());
    const auto refused = check_solvable(job, kMaxSolvedStates + 1);
    ASSERT_FALSE(refused.has_value());
    EXPECT_NE(refused.error().message.find("the chain has 65537"), std::string::npos) << refused.error().message;
  }
  for (const Method method : {Method::rollouts, Method::exact}) {
    job.method = method;
    EXPECT_TRUE(check_solvable(job, kMaxSolvedStates + 1).has_value());
  }
}

TEST(Method, NamesGoBothWays) {
  for (std::uint8_t method = 0; method < kMethods; ++method) {
    EXPECT_EQ(*value_named<Method>("method", name_of(Method{method})), Method{method});
  }
  const auto unknown = value_named<Method>("method", "exactly");
  ASSERT_FALSE(unknown.has_value());
  EXPECT_NE(unknown.error().message.find("rollouts, exact, discounted, long_run"), std::string::npos);
}

TEST(FixedPoint, GoesBothWays) {
  for (const double value : {0.0, 0.5, 0.95, 0.999999, 1.0}) {
    EXPECT_EQ(fixed_point_value(fixed_point_share(value)), value);
  }
}

}  // namespace
}  // namespace coppice
