#include "coordinator/sweep/plan.hpp"

#include <gtest/gtest.h>

#include "tests/coordinator/evolution/small_world.hpp"

namespace coppice {
namespace {

Result<SweepPlan> plan(const std::string& toml) { return read_sweep(toml, "sweep.toml", testing::small_vocabulary()); }

std::string refusal(const std::string& toml) {
  const auto read = plan(toml);
  return read ? "accepted" : read.error().message;
}

TEST(SweepPlan, RunsEveryCombinationWithEverySeed) {
  const auto read = plan(
      "seeds = 3\n[set]\nga.generations = 7\n[grid]\nrollout.acting = [\"tree\", \"policy\"]\nga.population = [10, "
      "20]\n");
  ASSERT_TRUE(read.has_value()) << read.error().message;
  EXPECT_EQ(read->keys, (std::vector<std::string>{"ga.population", "rollout.acting"}));
  ASSERT_EQ(read->settings.size(), 4U);
  EXPECT_EQ(read->label(0), "ga.population=10 rollout.acting=tree");
  EXPECT_EQ(read->label(1), "ga.population=10 rollout.acting=policy");
  EXPECT_EQ(read->label(3), "ga.population=20 rollout.acting=policy");
  const auto runs = read->runs();
  ASSERT_EQ(runs.size(), 12U);
  EXPECT_EQ(runs[4].setting, 1U);
  EXPECT_EQ(runs[4].config.seed, 2U);
  EXPECT_EQ(runs[4].config.ga.population, 10U);
  EXPECT_EQ(runs[4].config.ga.generations, 7U);
  EXPECT_EQ(runs[4].config.rollout.acting, Acting::policy);
}

TEST(SweepPlan, WithoutAGridIsOneSettingWithTheSeedsGiven) {
  const auto read = plan("seeds = [8, 3]\nepisodes = 0\n");
  ASSERT_TRUE(read.has_value()) << read.error().message;
  const auto runs = read->runs();
  ASSERT_EQ(runs.size(), 2U);
  EXPECT_EQ(runs[0].config.seed, 8U);
  EXPECT_EQ(runs[1].config.seed, 3U);
  EXPECT_EQ(read->label(0), "as configured");
  EXPECT_EQ(read->episodes, 0U);
}

TEST(SweepPlan, NamesFileAndLineOfWhatIsWrong) {
  EXPECT_EQ(refusal("seeds = 2\n[grid]\nga.population = [10, \"many\"]\n").rfind("sweep.toml: line 3: ", 0), 0U);
  EXPECT_NE(refusal("seeds = 2\n[grid]\nga.popul = [1]\n").find("unknown key 'popul'"), std::string::npos);
  EXPECT_EQ(refusal("seeds = 2\nseed = 3\n"),
            "sweep.toml: line 2: unknown key 'seed': expected one of config, seeds, episodes, [set], [grid]");
  EXPECT_EQ(refusal("[grid]\nga.population = [10]\n"), "sweep.toml: no seeds: expected seeds = 10, or a list of seeds");
  EXPECT_NE(refusal("seeds = [1, 1]\n").find("sweep.toml: line 1: seeds: expected"), std::string::npos);
  EXPECT_NE(refusal("seeds = 0\n").find("expected how many"), std::string::npos);
  EXPECT_NE(refusal("seeds = 1\n[grid]\nga.population = 10\n").find("line 3: ga.population: expected a list"),
            std::string::npos);
  EXPECT_NE(refusal("seeds = 1\n[grid]\nga.population = [10, 10]\n").find("10 is there twice"), std::string::npos);
  EXPECT_NE(refusal("seeds = 1\n[grid]\nseed = [1]\n").find("seed: expected in `seeds`"), std::string::npos);
  EXPECT_NE(refusal("seeds = 1\nepisodes = -1\n").find("line 2: episodes"), std::string::npos);
  EXPECT_NE(refusal("seeds = 1\nconfig = \"no such file.toml\"\n").find("sweep.toml: line 2: "), std::string::npos);
  EXPECT_NE(refusal("seeds = ").find("sweep.toml: line 1, column"), std::string::npos);
  EXPECT_NE(refusal("seeds = 100000\n[grid]\nga.elites = [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11]\n").find("more than"),
            std::string::npos);
}

TEST(SweepPlan, NamesTheSettingThatIsWrongAsAWhole) {
  const std::string said = refusal("seeds = 1\n[grid]\nga.elites = [1, 50]\nga.population = [20, 100]\n");
  EXPECT_EQ(said.rfind("sweep.toml: ga.elites=50 ga.population=20: ", 0), 0U) << said;
}

}  // namespace
}  // namespace coppice
