// What a run of several demes keeps of each of them.
#include "coordinator/runs/evolve_in_study.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <optional>
#include <string>

#include "common/stop.hpp"
#include "tests/coordinator/runs/learned_room.hpp"
#include "tests/temporary_folder.hpp"

namespace coppice {
namespace {

class EvolveInStudyTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { learned_chain_.emplace(learned_room()); }
  static void TearDownTestSuite() { learned_chain_.reset(); }

  EvolveInStudyTest() {
    config_.ga.search = Search::scalar;
    config_.ga.demes = 4;
    config_.ga.population = 40;
    config_.ga.generations = 30;
    config_.rollout.rollouts = 20;
    config_.seed = 7;
  }

  Study fresh(const std::string& name) {
    return std::move(
        Study::create(folder_ / name, *learned_chain_, StudyWorld{"uav", std::string(default_room())}, {}).value());
  }

  EvolveTask task(std::size_t threads) const {
    EvolveTask task;
    task.config = config_;
    task.evaluator.kind = EvaluatorChoice::Kind::serial;
    task.evaluator.threads = threads;
    return task;
  }

  testing::TemporaryFolder folder_;
  static std::optional<Chain> learned_chain_;
  EvolveConfig config_;
};

std::optional<Chain> EvolveInStudyTest::learned_chain_;

void expect_same(const DemeGenerations& kept, const DemeGenerations& expected) {
  EXPECT_EQ(kept.generation, expected.generation);
  EXPECT_EQ(kept.demes, expected.demes);
}

TEST_F(EvolveInStudyTest, KeepsEachDemesGenerationsTheSameForAnyNumberOfThreads) {
  Study one = fresh("one.coppice");
  Study three = fresh("three.coppice");
  const StopFlag stop;
  const auto by_one = evolve_in_study(one, task(1), stop, {});
  const auto by_three = evolve_in_study(three, task(3), stop, {});
  ASSERT_TRUE(by_one.has_value() && by_three.has_value());
  const auto kept = one.deme_generations(by_one->run).value();
  ASSERT_EQ(kept.demes.size(), 4U);
  ASSERT_EQ(kept.generation.size(), 30U);
  expect_same(three.deme_generations(by_three->run).value(), kept);
  // The run's own rows are made of them.
  const auto united = one.generations(by_one->run).value();
  for (std::size_t i = 0; i < united.size(); ++i) {
    double best = kept.demes.front()[i].best_fitness;
    std::uint64_t evaluations = 0;
    for (const auto& deme : kept.demes) {
      best = std::max(best, deme[i].best_fitness);
      evaluations += deme[i].evaluations;
    }
    EXPECT_EQ(united[i].best.fitness, best) << "generation " << i;
    EXPECT_EQ(united[i].evaluations, evaluations) << "generation " << i;
  }
}

TEST_F(EvolveInStudyTest, KeepsWhatWasBeforeAnInterruption) {
  Study whole = fresh("whole.coppice");
  Study halved = fresh("halved.coppice");
  const StopFlag never;
  const auto at_once = evolve_in_study(whole, task(1), never, {});
  ASSERT_TRUE(at_once.has_value());

  StopFlag stop;
  EvolveWatch watch;
  watch.generation_done = [&](const GenerationRecord& record, const DispatchStatistics&) {
    if (record.generation >= 9) {
      stop.raise();
    }
  };
  const auto first = evolve_in_study(halved, task(1), stop, watch);
  ASSERT_TRUE(first.has_value() && first->interrupted());
  const std::size_t before = halved.deme_generations(first->run).value().generation.size();
  EXPECT_GE(before, 10U) << "what is done shows before the run has ended";
  EXPECT_LT(before, 30U);

  EvolveTask rest = task(2);
  rest.resumed = first->run;
  ASSERT_TRUE(evolve_in_study(halved, rest, never, {}).has_value());
  expect_same(halved.deme_generations(first->run).value(), whole.deme_generations(at_once->run).value());
}

TEST_F(EvolveInStudyTest, OneDemeHasNoneBesideTheRunsOwn) {
  Study study = fresh("single.coppice");
  config_.ga.demes = 1;
  config_.ga.generations = 5;
  const StopFlag stop;
  const auto report = evolve_in_study(study, task(1), stop, {});
  ASSERT_TRUE(report.has_value());
  EXPECT_TRUE(study.deme_generations(report->run).value().demes.empty());
  EXPECT_EQ(study.generations(report->run).value().size(), 5U);
}

}  // namespace
}  // namespace coppice
