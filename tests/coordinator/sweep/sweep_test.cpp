#include "coordinator/sweep/sweep.hpp"

#include <gtest/gtest.h>
#include <set>

#include "coordinator/sweep/sweep_report.hpp"
#include "tests/coordinator/evolution/small_world.hpp"

namespace coppice {
namespace {

class SweepOnSmallChain : public ::testing::Test {
 protected:
  SweepOnSmallChain() {
    settings_.new_evaluator = [this] { return std::make_unique<testing::WalkingEvaluator>(chain_); };
    plan_ = *read_sweep("seeds = 4\n[set]\nga.generations = 5\nga.population = 12\n[grid]\nga.mutation = [0.1, 0.5]\n",
                        "sweep.toml", chain_.vocabulary());
  }

  Result<void> run(std::size_t at_once, SweepResults& results) {
    const auto runs = plan_.runs();
    results.assign(runs.size(), std::nullopt);
    settings_.at_once = at_once;
    SweepHooks hooks;
    hooks.run_done = [&](std::size_t run, const SweepResult& result) -> Result<void> {
      results[run] = result;
      results[run]->seconds = 0.0;
      return {};
    };
    return sweep(chain_, nullptr, runs, settings_, hooks, stop_);
  }

  const Chain chain_ = testing::small_chain();
  SweepSettings settings_;
  SweepPlan plan_;
  StopFlag stop_;
};

TEST_F(SweepOnSmallChain, GivesEveryRunWhatItHasAlone) {
  SweepResults together;
  SweepResults alone;
  ASSERT_TRUE(run(5, together).has_value());
  ASSERT_TRUE(run(1, alone).has_value());
  EXPECT_EQ(together, alone);
  std::set<double> fitness;
  for (const auto& result : alone) {
    ASSERT_TRUE(result.has_value());
    fitness.insert(result->fitness);
    EXPECT_GT(result->distinct, 0.0);
    EXPECT_LE(result->distinct, 1.0);
    EXPECT_GT(result->meanings, 0.0);
    EXPECT_LT(result->meanings, result->distinct) << "different trees often mean the same";
    EXPECT_EQ(result->nodes, result->tree.size());
  }
  EXPECT_GT(fitness.size(), 1U);
}

TEST_F(SweepOnSmallChain, EndsWithTheErrorOfAHookAndReportsNoMore) {
  int done = 0;
  SweepHooks hooks;
  hooks.run_done = [&](std::size_t, const SweepResult&) -> Result<void> {
    return ++done == 3 ? failed("disk full") : Result<void>();
  };
  settings_.at_once = 3;
  const auto swept = sweep(chain_, nullptr, plan_.runs(), settings_, hooks, stop_);
  ASSERT_FALSE(swept.has_value());
  EXPECT_EQ(swept.error().message, "disk full");
  EXPECT_EQ(done, 3);
}

TEST_F(SweepOnSmallChain, StopsWhenItIsToldTo) {
  int generations = 0;
  SweepHooks hooks;
  hooks.generation_done = [&](std::size_t, const GenerationRecord&) {
    if (++generations == 7) {
      stop_.raise();
    }
  };
  const auto swept = sweep(chain_, nullptr, plan_.runs(), settings_, hooks, stop_);
  ASSERT_FALSE(swept.has_value());
  EXPECT_EQ(swept.error().kind, ErrorKind::interrupted);
  EXPECT_GE(generations, 7);
  EXPECT_LT(generations, static_cast<int>(plan_.runs().size() * plan_.runs().front().config.ga.generations));
}

TEST_F(SweepOnSmallChain, IsReportedSettingBySettingWithoutThoseThatHaveNoRun) {
  SweepResults results;
  ASSERT_TRUE(run(2, results).has_value());
  for (std::size_t i = 4; i < 8; ++i) {
    results[i].reset();
  }
  results[1].reset();
  const std::string table = to_text(plan_, results);
  EXPECT_NE(table.find("ga.mutation=0.1     3"), std::string::npos) << table;
  EXPECT_EQ(table.find("ga.mutation=0.5"), std::string::npos) << table;
  const std::string csv = runs_csv(plan_, results, chain_.vocabulary());
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 4);
  EXPECT_EQ(csv.rfind("ga.mutation,seed,coverage,agreement,fitness,nodes,distinct,meanings,seconds,tree\n0.1,1,", 0),
            0U)
      << csv;
  const auto plot = plot_of(plan_, results, "it's a title");
  ASSERT_TRUE(plot.has_value());
  EXPECT_EQ(plot->settings, std::vector<std::string>{"ga.mutation=0.1"});
  EXPECT_NE(to_gnuplot(*plot).find("set multiplot title 'it''s a title'"), std::string::npos);
}

}  // namespace
}  // namespace coppice
