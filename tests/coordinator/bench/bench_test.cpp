#include <gtest/gtest.h>

#include "coordinator/bench/bench_report.hpp"
#include "coordinator/bench/demes_report.hpp"
#include "coordinator/bench/machine.hpp"
#include "coordinator/bench/measurement.hpp"
#include "coordinator/bench/scaling.hpp"
#include "coordinator/bench/workload.hpp"
#include "tests/oracles/chains.hpp"

namespace coppice {
namespace {

TEST(Spread, IsTheMedianAndTheQuartiles) {
  const Spread spread = spread_of({5.0, 1.0, 100.0, 3.0, 2.0});
  EXPECT_DOUBLE_EQ(spread.median, 3.0);
  EXPECT_DOUBLE_EQ(spread.low, 2.0);
  EXPECT_DOUBLE_EQ(spread.high, 5.0);
  EXPECT_DOUBLE_EQ(spread_of({7.0}).high, 7.0);
  EXPECT_DOUBLE_EQ(spread_of({1.0, 2.0}).median, 1.5);
}

TEST(Machine, IsNamed) {
  const Machine machine = this_machine();
  EXPECT_GE(machine.cores, 1U);
  EXPECT_FALSE(machine.processor.empty());
  EXPECT_NE(machine.system.find("Linux"), std::string::npos) << machine.system;
}

TEST(Workload, IsTheSameEveryTime) {
  const Chain chain = oracles::random_chain({});
  const auto first = standard_workloads(chain);
  const auto second = standard_workloads(chain);
  ASSERT_EQ(first.size(), second.size());
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].trees, second[i].trees);
    EXPECT_EQ(first[i].job, second[i].job);
    for (const Tree& tree : first[i].trees) {
      EXPECT_TRUE(check_tree(tree, chain.vocabulary()).has_value());
    }
    EXPECT_TRUE(check_job(first[i].job).has_value());
    EXPECT_EQ(first[i].job_of(3).generation, 3U);
  }
  EXPECT_EQ(light_workload(chain, 7).trees.size(), 7U);
}

// Serial 1 ms a generation; 2 workers take 0.5 ms and 0.3 ms of overhead: they save half of a generation's time.
std::vector<WorkloadScaling> some_scaling() {
  WorkloadScaling light{"light", 100, 5, 100, {1e-3, 1e-3, 1e-3}, 2, {0.6e-3, 0.6e-3, 0.6e-3}, {1.7, 1.7, 1.7}, {}};
  ScalingRow two;
  two.team = {2};
  two.seconds = {0.8e-3, 0.8e-3, 0.8e-3};
  two.speed_up = {1.25, 1.25, 1.25};
  two.overhead = {0.3e-3, 0.3e-3, 0.3e-3};
  light.rows = {two};
  return {light};
}

TEST(Scaling, BreaksEvenWhereWhatIsSavedIsTheOverhead) {
  EXPECT_DOUBLE_EQ(worthwhile_seconds(some_scaling(), {2}, 2), 0.6e-3);
  EXPECT_DOUBLE_EQ(worthwhile_seconds(some_scaling(), {2}, 1), 0.0);  // one core: never
  EXPECT_DOUBLE_EQ(worthwhile_seconds(some_scaling(), {4}, 2), 0.0);  // not measured
}

TEST(Scaling, ShowsWhatTheCoresGiveWithoutDispatch) {
  const std::string text = to_text(some_scaling().front());
  EXPECT_NE(text.find("2 serial"), std::string::npos) << text;
  EXPECT_NE(text.find("1.70    85%"), std::string::npos) << text;
}

TEST(DemePlan, IsLimitedByDemesByCoresAndByTheCoordinator) {
  const EpochCosts free_way{.core = 50e-3, .lost = 0.0, .coordinator = 0.5e-3};
  EXPECT_DOUBLE_EQ(predicted_speed_up(free_way, 64, 16), 16.0);
  EXPECT_DOUBLE_EQ(predicted_speed_up(free_way, 12, 16), 12.0);
  EXPECT_DOUBLE_EQ(predicted_speed_up(free_way, 400, 400), 100.0);  // 50 ms / 0.5 ms
  EXPECT_DOUBLE_EQ(predicted_speed_up({50e-3, 12.5e-3, 0.5e-3}, 64, 10), 8.0);
}

// 10 ms an epoch; two serial runs at once take 1.6 times one; two workers 0.6 s for 100 epochs.
DemeScaling some_demes() {
  DemeScaling scaling;
  scaling.name = "thesis";
  scaling.demes = 8;
  scaling.epochs = 100;
  scaling.individuals = 100'000;
  scaling.serial_seconds = {1.0, 1.0, 1.0};
  scaling.abreast = 2;
  scaling.abreast_speed_up = {2.0, 2.0, 2.0};
  DemeRow threads;
  threads.name = "2 threads";
  threads.lanes = 2;
  threads.seconds = {0.5, 0.5, 0.5};
  DemeRow workers;
  workers.name = "2 workers";
  workers.lanes = 2;
  workers.seconds = {0.6, 0.6, 0.6};
  workers.bytes = 6.0;
  workers.busy = 100e-6;
  scaling.rows = {threads, workers};
  return scaling;
}

TEST(DemePlan, ChargesAnEpochWhatWorkersTookLongerThanTheCoresAlone) {
  const DemePlan plan = plan_of(some_demes(), {.hosts = 2, .cores = 2});
  EXPECT_DOUBLE_EQ(plan.costs.core, 10e-3);
  EXPECT_NEAR(plan.costs.lost, 2e-3, 1e-12);
  EXPECT_DOUBLE_EQ(plan.costs.coordinator, 100e-6);
  EXPECT_NEAR(plan.speed_up, 4.0 / 1.2, 1e-9);
  EXPECT_EQ(plan.limit, "the cores");
  EXPECT_EQ(plan_of(some_demes(), {.hosts = 4, .cores = 16}).limit, "the number of demes (ga.demes)");
  const std::string text = to_text(some_demes(), {.hosts = 2, .cores = 2}, plan);
  EXPECT_NE(text.find("3.3 times"), std::string::npos) << text;
}

TEST(Team, IsNamedByItsWorkersAndTheirThreads) {
  EXPECT_EQ((Team{2, 1}.name()), "2 workers");
  EXPECT_EQ((Team{1, 2}.name()), "1 worker x 2");
  EXPECT_EQ((Team{2, 4}.lanes()), 8U);
}

TEST(Verdict, SaysFromWhichWorkloadOnWorkersPay) {
  auto scaling = some_scaling();
  EXPECT_NE(verdict(scaling, 2).find("2 workers pay from the workload 'light' on"), std::string::npos)
      << verdict(scaling, 2);
  scaling[0].rows[0].speed_up = {0.9, 0.9, 0.9};
  EXPECT_NE(verdict(scaling, 2).find("2 workers pay in none"), std::string::npos) << verdict(scaling, 2);
  EXPECT_NE(verdict(scaling, 1).find("cannot pay"), std::string::npos) << verdict(scaling, 1);
}

}  // namespace
}  // namespace coppice
