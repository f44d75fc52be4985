#include "tests/e2e/cli/command_line.hpp"

namespace coppice::e2e {
namespace {

class Bench : public CommandLine {
 protected:
  static void expect_spread(const nlohmann::json& spread) {
    ASSERT_TRUE(spread.is_object()) << spread;
    EXPECT_LE(spread.at("low").get<double>(), spread.at("median").get<double>());
    EXPECT_LE(spread.at("median").get<double>(), spread.at("high").get<double>());
  }
};

TEST_F(Bench, ReportsEveryColumnForEveryNumberOfWorkers) {
  learn_study();
  const auto report = coppice_json({"bench", "--study", "study.coppice", "--workers", "1,2", "--workloads",
                                    "empty,light", "--repetitions", "1", "--json"});
  ASSERT_TRUE(report.is_object());
  EXPECT_GE(report.at("machine").at("cores").get<int>(), 1);
  EXPECT_FALSE(report.at("machine").at("processor").get<std::string>().empty());
  ASSERT_EQ(report.at("workloads").size(), 2U);
  for (const auto& workload : report.at("workloads")) {
    expect_spread(workload.at("serial").at("generation_seconds"));
    ASSERT_EQ(workload.at("workers").size(), 2U);
    for (const auto& row : workload.at("workers")) {
      for (const char* field : {"generation_seconds", "speed_up", "overhead_seconds", "bare_seconds"}) {
        expect_spread(row.at(field));
      }
      for (const char* field :
           {"evaluations_per_second", "efficiency", "batches", "bytes_per_individual", "coordinator_busy"}) {
        EXPECT_GT(row.at(field).get<double>(), 0.0) << field;
      }
    }
  }
  EXPECT_EQ(report.at("break_even").size(), 2U);
}

TEST_F(Bench, ComparesThreadsWithProcesses) {
  const auto report =
      coppice_json({"bench", "--workers", "2,1x2", "--workloads", "light", "--repetitions", "1", "--json"});
  const auto& rows = report.at("workloads").at(0).at("workers");
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0].at("threads"), 1);
  EXPECT_EQ(rows[1].at("workers"), 1);
  EXPECT_EQ(rows[1].at("threads"), 2);
}

TEST_F(Bench, MeasuresHowFastAChainReachesAWorker) {
  ASSERT_EQ(coppice({"synth", "-o", "large.coppice", "--states", "10000"}).ending, kDone);
  const auto report = coppice_json({"bench", "--transfer", "--study", "large.coppice", "--repetitions", "2", "--json"});
  EXPECT_EQ(report.at("blocks"), (report.at("bytes").get<std::uint64_t>() + 262143) / 262144);
  for (const char* field : {"start_seconds", "transfer_seconds", "bare_seconds", "share_of_bare_rate"}) {
    expect_spread(report.at(field));
    EXPECT_GT(report.at(field).at("median").get<double>(), 0.0) << field;
  }
  const Completed text = coppice({"bench", "--transfer", "--study", "large.coppice", "--repetitions", "1"});
  EXPECT_NE(text.output.find("of the bare rate"), std::string::npos) << text.output;
}

TEST_F(Bench, EndsWithAVerdict) {
  const Completed completed = coppice({"bench", "--workers", "1", "--workloads", "light", "--repetitions", "1"});
  ASSERT_EQ(completed.ending, kDone) << completed.error;
  EXPECT_NE(completed.output.find("Every tally was equal to the serial one."), std::string::npos) << completed.output;
  EXPECT_NE(completed.output.find("bare DDS"), std::string::npos) << completed.output;
}

TEST_F(Bench, PlansCapacityWithPacedWorkers) {
  const auto report = coppice_json({"bench", "--pace", "500us", "--slow", "1:2ms", "--workers", "2,3", "--population",
                                    "30", "--repetitions", "2", "--json"});
  EXPECT_EQ(report.at("pace_ns"), 500'000);
  EXPECT_EQ(report.at("slow_workers"), 1);
  ASSERT_EQ(report.at("paced").size(), 2U);
  for (const auto& row : report.at("paced")) {
    EXPECT_EQ(row.at("individuals"), 30);
    expect_spread(row.at("generation_seconds"));
    EXPECT_GT(row.at("efficiency").get<double>(), 0.0);
    EXPECT_GT(row.at("here_seconds").get<double>(), 0.0);
  }
  // 2 and 0.5 individuals a millisecond
  EXPECT_DOUBLE_EQ(report.at("paced")[0].at("ideal_seconds").get<double>(), 30.0 / 2500.0);
}

TEST_F(Bench, RefusesWrongFlags) {
  expect_wrong_use({"bench", "--workers", "0"}, {"--workers", "'0'", "1x2"});
  expect_wrong_use({"bench", "--workers", "1,2x"}, {"--workers", "'2x'", "1x2"});
  expect_wrong_use({"bench", "--pace", "2ms", "--workers", "1x2"}, {"--workers", "1 worker x 2", "--pace"});
  expect_wrong_use({"bench", "--workloads", "lite"}, {"--workloads", "lite", "light"});
  expect_wrong_use({"bench", "--pace", "2"}, {"--pace", "'2'", "2ms"});
  expect_wrong_use({"bench", "--slow", "1:20ms"}, {"--slow", "--pace"});
  expect_wrong_use({"bench", "--pace", "2ms", "--slow", "20ms"}, {"--slow", "1:20ms"});
  expect_wrong_use({"bench", "--pace", "2ms", "--workers", "2,8", "--slow", "3:20ms"}, {"--slow", "at most 2"});
  expect_wrong_use({"bench", "--study", "nothing.coppice"}, {"nothing.coppice"});
}

TEST_F(Bench, AWorkerRefusesAPaceThatIsNone) {
  const Completed completed =
      run_to_end({.program = COPPICE_WORKER_PROGRAM, .arguments = {"--pace", "soon"}, .folder = {}, .environment = {}});
  EXPECT_EQ(completed.ending, kWrongUse);
  EXPECT_NE(completed.error.find("--pace: 'soon'"), std::string::npos) << completed.error;
}

TEST_F(Bench, AWorkerRefusesCoresThatItCannotKeepTo) {
  const auto refusal = [](const std::string& cores) {
    const Completed completed = run_to_end(
        {.program = COPPICE_WORKER_PROGRAM, .arguments = {"--cores", cores}, .folder = {}, .environment = {}});
    EXPECT_EQ(completed.ending, kWrongUse);
    return completed.error;
  };
  EXPECT_NE(refusal("0,0").find("--cores: found 2, expected as many as there are evaluating threads, 1"),
            std::string::npos);
  EXPECT_NE(refusal("4095").find("--cores: found core 4095, expected some of"), std::string::npos);
}

}  // namespace
}  // namespace coppice::e2e
