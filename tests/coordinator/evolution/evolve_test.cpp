#include "coordinator/evolution/evolve.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <numeric>
#include <optional>
#include <vector>

#include "common/evolution/breeding.hpp"
#include "common/evolution/scalar_fitness.hpp"
#include "tests/coordinator/evolution/small_world.hpp"

namespace coppice {
namespace {

using testing::small_chain;
using testing::tree_of;
using testing::WalkingEvaluator;

EvolveConfig small_config() {
  EvolveConfig config;
  config.seed = 42;
  config.ga.generations = 12;
  config.ga.population = 40;
  config.rollout.rollouts = 2;
  config.rollout.steps = 30;
  config.rollout.final_rollouts = 10;
  return config;
}

struct SavedHistory {
  std::vector<GenerationRecord> records;
  std::vector<Checkpoint> checkpoints;

  EvolveHooks hooks() {
    return {[this](std::span<const GenerationRecord> told, const Checkpoint& checkpoint) -> Result<void> {
      for (const GenerationRecord& record : told) {
        records.push_back(record);
        records.back().seconds = 0.0;
      }
      checkpoints.push_back(checkpoint);
      return {};
    }};
  }
};

class Evolve : public ::testing::Test {
 protected:
  Result<Evolved> run(const EvolveConfig& config, SavedHistory& history,
                      std::optional<Checkpoint> start = std::nullopt) {
    return evolve(chain_, config, evaluator_, std::move(start), history.hooks());
  }

  Chain chain_ = small_chain();
  WalkingEvaluator evaluator_{chain_};
};

TEST_F(Evolve, ResumesFromAnyCheckpointToTheVerySameResult) {
  const EvolveConfig config = small_config();
  SavedHistory whole;
  const auto expected = run(config, whole);
  ASSERT_TRUE(expected.has_value()) << expected.error().message;
  ASSERT_EQ(whole.records.size(), config.ga.generations);
  for (std::size_t reached = 0; reached < whole.checkpoints.size(); ++reached) {
    SavedHistory rest;
    const auto resumed = run(config, rest, whole.checkpoints[reached]);
    ASSERT_TRUE(resumed.has_value());
    EXPECT_EQ(*resumed, *expected);
    EXPECT_TRUE(std::equal(rest.records.begin(), rest.records.end(),
                           whole.records.begin() + 1 + static_cast<std::ptrdiff_t>(reached), whole.records.end()));
    EXPECT_TRUE(std::equal(rest.checkpoints.begin(), rest.checkpoints.end(),
                           whole.checkpoints.begin() + 1 + static_cast<std::ptrdiff_t>(reached),
                           whole.checkpoints.end()));
  }
}

TEST_F(Evolve, AnotherSeedGivesAnotherEvolution) {
  EvolveConfig config = small_config();
  SavedHistory one;
  ASSERT_TRUE(run(config, one).has_value());
  ++config.seed;
  SavedHistory two;
  ASSERT_TRUE(run(config, two).has_value());
  EXPECT_NE(one.checkpoints.front().population, two.checkpoints.front().population);
}

TEST_F(Evolve, AsksForEveryGenerationByItsNumberAndForTheChampionsInTheEnd) {
  EvolveConfig config = small_config();
  config.rollout.acting = Acting::mixed;
  config.rollout.policy_share = 0.25;
  SavedHistory history;
  const auto evolved = run(config, history);
  ASSERT_TRUE(evolved.has_value());
  ASSERT_EQ(evaluator_.calls.size(), config.ga.generations + 1);
  for (std::uint32_t g = 0; g < config.ga.generations; ++g) {
    const Job& job = evaluator_.calls[g].job;
    EXPECT_EQ(job.generation, g);
    EXPECT_EQ(job.seed, config.seed);
    EXPECT_EQ(job.rollouts, 2U);
    EXPECT_EQ(job.policy_share, std::uint64_t{1} << 62U);
    EXPECT_EQ(evaluator_.calls[g].trees.size(), config.ga.population);
  }
  const WalkingEvaluator::Call& last = evaluator_.calls.back();
  EXPECT_EQ(last.job.generation, kFinalGeneration);
  EXPECT_EQ(last.job.rollouts, config.rollout.final_rollouts);
  std::vector<Tree> champions;
  for (const GenerationRecord& record : history.records) {
    if (std::find(champions.begin(), champions.end(), record.best.tree) == champions.end()) {
      champions.push_back(record.best.tree);
    }
  }
  EXPECT_EQ(last.trees, champions);
}

TEST_F(Evolve, AnswersWithTheChampionThatDoesBestOnTheFinalSample) {
  const EvolveConfig config = small_config();
  SavedHistory history;
  const auto evolved = run(config, history);
  ASSERT_TRUE(evolved.has_value());
  const auto fitness = ScalarFitness::make(chain_, config.fitness).value();
  const auto tallies = evaluator_.evaluate(evaluator_.calls.back().trees, evaluator_.calls.back().job).value();
  double best = ScalarFitness::kNone;
  for (const Tally& tally : tallies) {
    best = std::max(best, fitness.of(tally));
  }
  EXPECT_EQ(evolved->best.fitness, best);
  EXPECT_EQ(evolved->final_steps, 300U);
  EXPECT_FALSE(evolved->interrupted);
  const auto led = std::find_if(history.records.begin(), history.records.end(),
                                [&](const GenerationRecord& r) { return r.best.tree == evolved->best.tree; });
  ASSERT_NE(led, history.records.end());
  EXPECT_EQ(evolved->best.generation, led->generation);
}

TEST_F(Evolve, RecordsWhatThePopulationIs) {
  const EvolveConfig config = small_config();
  SavedHistory history;
  ASSERT_TRUE(run(config, history).has_value());
  for (std::size_t g = 0; g < history.records.size(); ++g) {
    const GenerationRecord& record = history.records[g];
    const Checkpoint& checkpoint = history.checkpoints[g];
    EXPECT_EQ(record.generation, g);
    EXPECT_EQ(checkpoint.generation, g);
    EXPECT_EQ(record.evaluations, 40U);
    EXPECT_EQ(record.best.fitness, *std::max_element(checkpoint.fitness.begin(), checkpoint.fitness.end()));
    EXPECT_DOUBLE_EQ(record.mean_fitness,
                     std::accumulate(checkpoint.fitness.begin(), checkpoint.fitness.end(), 0.0) / 40.0);
    double nodes = 0.0;
    for (const Tree& tree : checkpoint.population) {
      nodes += static_cast<double>(tree.size());
    }
    EXPECT_DOUBLE_EQ(record.mean_nodes, nodes / 40.0);
    EXPECT_GE(record.distinct_trees, 1U);
    EXPECT_LE(record.distinct_trees, 40U);
  }
}

TEST_F(Evolve, WithAnEliteAndNoChanceInTheObjectiveTheBestNeverFalls) {
  EvolveConfig config = small_config();
  config.ga.generations = 30;
  config.fitness.agreement = 0.0;
  config.fitness.coverage = 1.0;
  config.fitness.size_weight = 0.0;
  double gained = 0.0;
  for (config.seed = 1; config.seed <= 5; ++config.seed) {
    SavedHistory history;
    const auto evolved = run(config, history);
    ASSERT_TRUE(evolved.has_value());
    for (std::size_t g = 1; g < history.records.size(); ++g) {
      EXPECT_GE(history.records[g].best.fitness, history.records[g - 1].best.fitness);
    }
    EXPECT_EQ(evolved->best.fitness, history.records.back().best.fitness);
    gained += evolved->best.fitness - history.records.front().best.fitness;
  }
  EXPECT_GT(gained, 0.0);
}

TEST_F(Evolve, FindsAPlantedPolicy) {
  EvolveConfig config = small_config();
  config.ga.generations = 150;
  config.ga.population = 100;
  double best = 0.0;
  for (config.seed = 1; config.seed <= 5 && best < 1.0; ++config.seed) {
    SavedHistory history;
    const auto evolved = run(config, history);
    ASSERT_TRUE(evolved.has_value());
    best = std::max(best, evolved->best.agreement);
  }
  EXPECT_GT(best, 0.97) << "none of five seeds found a policy of eight nodes";
}

TEST_F(Evolve, InterruptedKeepsTheBestOnRecordAndCanBeResumed) {
  const EvolveConfig config = small_config();
  SavedHistory whole;
  const auto expected = run(config, whole);
  for (const std::size_t stop_at : {std::size_t{1}, std::size_t{7}, std::size_t{12}}) {  // 12: the final evaluation
    WalkingEvaluator stopped(chain_);
    stopped.stop_at = stop_at;
    SavedHistory history;
    const auto evolved = evolve(chain_, config, stopped, std::nullopt, history.hooks());
    ASSERT_TRUE(evolved.has_value());
    EXPECT_TRUE(evolved->interrupted);
    EXPECT_EQ(evolved->generations_done, stop_at);
    EXPECT_EQ(evolved->final_steps, 0U);
    EXPECT_EQ(stopped.calls.size(), stop_at + 1) << "nothing is evaluated after an interruption";
    double best = ScalarFitness::kNone;
    for (const GenerationRecord& record : history.records) {
      best = std::max(best, record.best.fitness);
    }
    EXPECT_EQ(evolved->best.fitness, best);

    SavedHistory rest;
    const auto resumed = run(config, rest, history.checkpoints.back());
    ASSERT_TRUE(resumed.has_value());
    EXPECT_EQ(*resumed, *expected);
  }
}

TEST_F(Evolve, InterruptedBeforeTheFirstGenerationHasNothingToKeep) {
  evaluator_.stop_at = 0;
  SavedHistory history;
  const auto evolved = run(small_config(), history);
  ASSERT_FALSE(evolved.has_value());
  EXPECT_EQ(evolved.error().kind, ErrorKind::interrupted);
}

TEST_F(Evolve, AFailureOfTheEvaluatorEndsTheEvolution) {
  evaluator_.stop_at = 5;
  evaluator_.error = {ErrorKind::failed, "no worker for 60 s"};
  SavedHistory history;
  const auto evolved = run(small_config(), history);
  ASSERT_FALSE(evolved.has_value());
  EXPECT_EQ(evolved.error().kind, ErrorKind::failed);
  EXPECT_EQ(evolved.error().message, "no worker for 60 s");
  EXPECT_EQ(history.checkpoints.size(), 5U);
}

TEST_F(Evolve, TellsOfGenerationsTogetherWhenTheyAreDue) {
  const EvolveConfig config = small_config();
  SavedHistory each;
  const auto expected = run(config, each);
  ASSERT_TRUE(expected.has_value());
  SavedHistory history;
  EvolveHooks hooks = history.hooks();
  std::size_t asked = 0;
  hooks.due = [&] { return ++asked % 3 == 0; };
  EXPECT_EQ(evolve(chain_, config, evaluator_, std::nullopt, hooks).value(), *expected);
  EXPECT_EQ(history.records, each.records);
  ASSERT_FALSE(history.checkpoints.empty());
  EXPECT_LT(history.checkpoints.size(), each.checkpoints.size());
  for (const Checkpoint& checkpoint : history.checkpoints) {
    EXPECT_EQ(checkpoint, each.checkpoints[checkpoint.generation]);
  }
  EXPECT_EQ(history.checkpoints.back().generation, config.ga.generations - 1);
}

TEST_F(Evolve, TellsOfWhatWasDoneBeforeAFailureUnlessItRestsOnALie) {
  for (const ErrorKind kind : {ErrorKind::failed, ErrorKind::interrupted, ErrorKind::revoked}) {
    evaluator_.stop_at = 5;
    evaluator_.calls.clear();
    evaluator_.error = {kind, "ended"};
    SavedHistory history;
    EvolveHooks hooks = history.hooks();
    hooks.due = [] { return false; };
    static_cast<void>(evolve(chain_, small_config(), evaluator_, std::nullopt, hooks));
    EXPECT_EQ(history.records.size(), kind == ErrorKind::revoked ? 0U : 5U);
    EXPECT_EQ(history.checkpoints.size(), kind == ErrorKind::revoked ? 0U : 1U);
  }
}

TEST_F(Evolve, AHookCanStopIt) {
  EvolveHooks full{[](std::span<const GenerationRecord> records, const Checkpoint&) -> Result<void> {
    return records.back().generation == 3 ? Result<void>(failed("disk full")) : Result<void>();
  }};
  const auto evolved = evolve(chain_, small_config(), evaluator_, std::nullopt, full);
  ASSERT_FALSE(evolved.has_value());
  EXPECT_EQ(evolved.error().message, "disk full");
  EvolveHooks enough{[](std::span<const GenerationRecord> records, const Checkpoint&) -> Result<void> {
    return records.back().generation == 3 ? Result<void>(tl::unexpected(Error{ErrorKind::interrupted, "q"}))
                                          : Result<void>();
  }};
  const auto stopped = evolve(chain_, small_config(), evaluator_, std::nullopt, enough);
  ASSERT_TRUE(stopped.has_value());
  EXPECT_TRUE(stopped->interrupted);
  EXPECT_EQ(stopped->generations_done, 4U);
}

TEST_F(Evolve, RefusesACheckpointThatDoesNotFit) {
  const EvolveConfig config = small_config();
  SavedHistory history;
  ASSERT_TRUE(run(config, history).has_value());
  const auto refused = [&](const EvolveConfig& changed, const Checkpoint& start) {
    SavedHistory none;
    const auto evolved = run(changed, none, start);
    EXPECT_TRUE(none.records.empty());
    return !evolved.has_value() && evolved.error().kind == ErrorKind::bad_input;
  };
  EvolveConfig shorter = config;
  shorter.ga.generations = 5;
  EXPECT_TRUE(refused(shorter, history.checkpoints[5]));
  Checkpoint fewer = history.checkpoints[5];
  fewer.population.pop_back();
  EXPECT_TRUE(refused(config, fewer));
  EvolveConfig shallow = config;
  shallow.ga.max_depth = 0;
  EXPECT_TRUE(refused(shallow, history.checkpoints[5]));
  Checkpoint foreign = history.checkpoints[5];
  foreign.hall_of_fame.front().tree = Tree(ActionId{63});
  EXPECT_TRUE(refused(config, foreign));
}

TEST_F(Evolve, AnIndividualWithoutAResultRanksLastAndLeavesTheMeansAlone) {
  class Poisoned : public Evaluator {
   public:
    Result<std::vector<Tally>> evaluate(std::span<const Tree> trees, const Job& job) override {
      std::vector<Tally> tallies;
      for (const Tree& tree : trees) {
        tallies.push_back({static_cast<std::uint32_t>(tree.size()), 10, 100, {10}});
      }
      if (job.generation == 0) {
        tallies[0] = {0, 0, 0, {0}};
      }
      return tallies;
    }
    DispatchStatistics statistics() const override { return {}; }
  } evaluator;
  EvolveConfig config = small_config();
  config.ga.generations = 1;
  SavedHistory history;
  const auto evolved = evolve(chain_, config, evaluator, std::nullopt, history.hooks());
  ASSERT_TRUE(evolved.has_value());
  EXPECT_DOUBLE_EQ(history.records[0].mean_fitness, 0.1);
  EXPECT_EQ(history.checkpoints[0].fitness[0], ScalarFitness::kNone);
  EXPECT_EQ(history.records[0].best.fitness, 0.1);
}

TEST(HallOfFame, KeepsDistinctTreesWithTheirFirstGenerationAndBestFitness) {
  HallOfFame hall;
  enter({tree_of("move"), 0, 0.5, 0.5}, hall);
  enter({tree_of("left"), 1, 0.7, 0.6}, hall);
  enter({tree_of("move"), 2, 0.7, 0.7}, hall);
  enter({tree_of("move"), 3, 0.1, 0.1}, hall);
  EXPECT_EQ(hall, (HallOfFame{{tree_of("move"), 0, 0.7, 0.7}, {tree_of("left"), 1, 0.7, 0.6}}));
  EXPECT_EQ(best_on_record(hall).tree, tree_of("move"));
  enter({tree_of("(sequence a=0 left)"), 4, 0.9, 0.9}, hall);
  EXPECT_EQ(best_on_record(hall).generation, 4U);
}

}  // namespace
}  // namespace coppice
