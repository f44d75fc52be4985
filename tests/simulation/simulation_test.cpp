// The simulation in the suite: a corpus of seeds in which every promise holds, and faults put into the dispatcher one
// at a time, each of which it must find.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "coordinator/dispatch/mutation.hpp"
#include "tests/simulation/trial.hpp"

namespace coppice::simulation {
namespace {

constexpr std::uint64_t kMostSeedsToFind = 4'000;  // about 10 s; a mutation that these do not find is not found

std::string told(const Scenario& scenario, const Finding& finding, const std::string& mutation) {
  const Scenario small = shrunk(scenario, finding);
  return fmt::format("seed {}: {}\nreplay: {}", scenario.seed, finding.how, command_of(small, mutation));
}

// A block of the corpus: every block is a test, so that they run beside each other.
class Corpus : public ::testing::TestWithParam<std::uint64_t> {
 public:
  static constexpr std::uint64_t kSeeds = COPPICE_SIMULATION_SEEDS;
};

TEST_P(Corpus, KeepsEveryPromise) {
  std::uint64_t requests = 0;
  for (std::uint64_t seed = GetParam() * kSeeds; seed < (GetParam() + 1) * kSeeds; ++seed) {
    const Scenario scenario = scenario_of(seed);
    Report report;
    if (const auto finding = run_here(scenario, &report)) {
      FAIL() << told(scenario, *finding, "");
    }
    requests += report.requests;
  }
  RecordProperty("requests", std::to_string(requests));
  std::printf("%lu requests\n", requests);
}

INSTANTIATE_TEST_SUITE_P(Simulation, Corpus, ::testing::Range<std::uint64_t>(0, 4));

class Mutations : public ::testing::TestWithParam<const char*> {
 protected:
  void TearDown() override { set_mutation("none"); }
};

TEST_P(Mutations, AreFound) {
  ASSERT_TRUE(set_mutation(GetParam()));
  for (std::uint64_t seed = 0; seed < kMostSeedsToFind; ++seed) {
    if (const auto finding = run_apart(scenario_of(seed))) {
      std::printf("found by seed %lu: %s\n", seed, finding->how.c_str());
      return;
    }
  }
  FAIL() << "nothing was found in " << kMostSeedsToFind << " seeds";
}

INSTANTIATE_TEST_SUITE_P(Simulation, Mutations, ::testing::ValuesIn(kMutationNames.begin() + 1, kMutationNames.end()),
                         [](const auto& mutation) { return std::string(mutation.param); });

class Arrival : public ::testing::TestWithParam<std::uint32_t> {};

TEST_P(Arrival, AtOnceOverwhelmsNothing) {
  Report report;
  const auto finding = run_here(arrival_of(GetParam()), &report);
  ASSERT_FALSE(finding) << finding->how;
  EXPECT_EQ(report.requests, 1U);
  EXPECT_GT(report.all_ready, 0);
  EXPECT_LT(bytes_of_a_worker(GetParam()), 2048U);
}

INSTANTIATE_TEST_SUITE_P(Simulation, Arrival, ::testing::Values(500U, 1000U));

TEST(Simulation, IsTheSameEachTime) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    Report first;
    Report second;
    run_here(scenario_of(seed), &first);
    run_here(scenario_of(seed), &second);
    EXPECT_EQ(first.actions_hash, second.actions_hash) << seed;
    EXPECT_EQ(first.steps, second.steps) << seed;
  }
}

TEST(Simulation, MakesAFailingRunSmaller) {
  ASSERT_TRUE(set_mutation("credit_never_returned"));
  std::optional<Finding> finding;
  Scenario scenario;
  for (std::uint64_t seed = 0; seed < kMostSeedsToFind && !finding; ++seed) {
    scenario = scenario_of(seed);
    finding = run_apart(scenario);
  }
  ASSERT_TRUE(finding);
  const Scenario small = shrunk(scenario, *finding);
  const auto again = run_apart(small);
  set_mutation("none");
  ASSERT_TRUE(again);
  EXPECT_EQ(again->name, finding->name);
  EXPECT_LE(small.total_requests() * small.units, scenario.total_requests() * scenario.units);
  EXPECT_LE(small.faults.size(), scenario.faults.size());
  EXPECT_NE(command_of(small, "credit_never_returned").find("--seed"), std::string::npos);
}

}  // namespace
}  // namespace coppice::simulation
