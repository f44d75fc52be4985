#include <signal.h>

#include "tests/e2e/cli/command_line.hpp"

namespace coppice::e2e {
namespace {

class Evolve : public CommandLine {
 protected:
  void SetUp() override { learn_study(); }

  // Small, and the same for every way to evaluate.
  std::vector<std::string> small(std::vector<std::string> more) const {
    std::vector<std::string> arguments = {"evolve", "study.coppice",     "--config", "thesis",
                                          "--set",  "ga.generations=12", "--set",    "ga.population=40"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
};

TEST_F(Evolve, TheRunIsReportedAndKept) {
  const auto report = coppice_json(small({"--serial", "--seed", "3", "--json"}));
  EXPECT_EQ(report["run"], 1);
  EXPECT_EQ(report["status"], "finished");
  EXPECT_EQ(report["generations"], 12);
  const auto run = coppice_json({"info", "study.coppice", "--json"})["runs"].at(0);
  EXPECT_EQ(run["seed"], 3);
  EXPECT_EQ(run["configuration"]["ga"]["population"], 40);
  EXPECT_EQ(run["tree"], report["tree"]);
  EXPECT_EQ(run["pruned"], report["pruned"]);
  EXPECT_EQ(run["result"]["fitness"], report["fitness"]);
  const auto score = coppice_json({"score", "study.coppice", "--episodes", "3", "--json"});
  EXPECT_EQ(score["tree_text"], report["tree"]);
  EXPECT_EQ(score["pruned_text"], report["pruned"]);
}

TEST_F(Evolve, WorkersEndWithTheTreeAndTheFiguresOfTheSerialRun) {
  auto serial = coppice_json(small({"--serial", "--json"}));
  auto workers = coppice_json(small({"--workers", "2", "--json"}));
  for (auto* report : {&serial, &workers}) {
    for (const char* differs : {"run", "evaluator", "seconds", "dispatch"}) {
      EXPECT_EQ(report->erase(differs), 1U) << differs;
    }
  }
  EXPECT_EQ(serial, workers);
}

TEST_F(Evolve, WorkersEndWithTheFiguresOfTheSerialRunByEveryMethodThatComputes) {
  for (const char* method : {"exact", "discounted", "long_run"}) {
    const std::string setting = std::string("rollout.method=") + method;
    auto serial = coppice_json(small({"--serial", "--json", "--set", setting}));
    auto workers = coppice_json(small({"--workers", "2", "--json", "--set", setting}));
    for (auto* report : {&serial, &workers}) {
      for (const char* differs : {"run", "evaluator", "seconds", "dispatch"}) {
        EXPECT_EQ(report->erase(differs), 1U) << differs;
      }
    }
    EXPECT_EQ(serial, workers) << method;
    EXPECT_GT(serial["final_steps"], 8'000'000) << method;
  }
}

TEST_F(Evolve, TheSeedOfTheCommandLineWinsOverTheFile) {
  write("small.toml", "seed = 8\n[ga]\ngenerations = 2\npopulation = 10\n");
  EXPECT_EQ(coppice_json({"evolve", "study.coppice", "--serial", "--config", "small.toml", "--json"})["seed"], 8);
  EXPECT_EQ(
      coppice_json({"evolve", "study.coppice", "--serial", "--config", "small.toml", "--seed", "9", "--json"})["seed"],
      9);
}

TEST_F(Evolve, ProgressIsPlainLinesWhenNobodyWatches) {
  const Completed completed = coppice(small({"--serial", "--lines-every", "4"}));
  ASSERT_EQ(completed.ending, kDone) << completed.error;
  for (const char* line : {"evolve: 4/12 generations", "evolve: 8/12 generations", "evolve: 12/12 generations"}) {
    EXPECT_NE(completed.error.find(line), std::string::npos) << completed.error;
  }
  EXPECT_EQ(completed.error.find('\r'), std::string::npos);
  EXPECT_EQ(completed.output.find("evolve:"), std::string::npos);
}

TEST_F(Evolve, AMalformedConfigurationIsNamedAndLeavesNoRun) {
  write("bad.toml", "[ga]\npopulation = 10\ngenerations = \"many\"\n");
  expect_wrong_use({"evolve", "study.coppice", "--serial", "--config", "bad.toml"},
                   {"bad.toml", "line 3", "generations"});
  expect_wrong_use({"evolve", "study.coppice", "--serial", "--config", "none.toml"}, {"none.toml"});
  expect_wrong_use({"evolve", "study.coppice", "--serial", "--set", "ga.populaton=3"}, {"--set", "populaton"});
  expect_wrong_use({"evolve", "study.coppice", "--serial", "--resume"}, {"study.coppice", "resume"});
  expect_wrong_use({"evolve", "study.coppice", "--workers", "0"}, {"--workers", "0"});
  EXPECT_TRUE(coppice_json({"info", "study.coppice", "--json"})["runs"].empty());
}

TEST_F(Evolve, AWorkerProgramThatIsMissingIsAFailure) {
  const Completed completed = coppice(small({"--workers", "1", "--worker-program", "/nonexistent/worker"}));
  EXPECT_EQ(completed.ending, kFailed) << completed.error;
  EXPECT_NE(completed.error.find("/nonexistent/worker"), std::string::npos) << completed.error;
  EXPECT_TRUE(coppice_json({"info", "study.coppice", "--json"})["runs"].empty());
}

TEST_F(Evolve, AStudyThatIsRemovedMeanwhileIsAFailure) {
  Process process(command({"evolve", "study.coppice", "--serial", "--config", "thesis", "--set",
                           "ga.generations=100000", "--set", "ga.population=20", "--lines-every", "1"}));
  process.await_error("evolve: 2/100000 generations");
  std::filesystem::remove(path("study.coppice"));
  EXPECT_EQ(process.wait(), kFailed);
  EXPECT_NE(process.rest_of_error().find("removed or replaced"), std::string::npos);
}

TEST_F(Evolve, InfoShowsOneRunWhereItIsAskedFor) {
  for (const char* seed : {"1", "2"}) {
    ASSERT_EQ(coppice({"evolve", "study.coppice", "--config", "thesis", "--serial", "--seed", seed, "--set",
                       "ga.generations=2", "--set", "ga.population=10"})
                  .ending,
              kDone);
  }
  EXPECT_EQ(coppice_json({"info", "study.coppice", "--json"})["runs"].size(), 2U);
  const auto runs = coppice_json({"info", "study.coppice", "--run", "2", "--json"})["runs"];
  ASSERT_EQ(runs.size(), 1U);
  EXPECT_EQ(runs[0]["run"], 2);
  EXPECT_EQ(runs[0]["seed"], 2);
  const std::string text = coppice({"info", "study.coppice", "--run", "1"}).output;
  EXPECT_NE(text.find("run 1 "), std::string::npos) << text;
  EXPECT_EQ(text.find("run 2 "), std::string::npos) << text;
  expect_wrong_use({"info", "study.coppice", "--run", "3"}, {"study.coppice", "run 3"});
}

TEST_F(Evolve, AnInterruptionKeepsTheBestSoFarAndResumeGoesOn) {
  const std::vector<std::string> endless = {
      "evolve", "study.coppice",    "--config",      "thesis", "--serial", "--set", "ga.generations=100000",
      "--set",  "ga.population=20", "--lines-every", "1"};
  Process process(command(endless));
  process.await_error("evolve: 5/100000 generations");
  process.signal(SIGINT);
  EXPECT_EQ(process.wait(), kInterrupted);
  EXPECT_NE(process.rest_of_output().find("pruned, "), std::string::npos);
  EXPECT_NE(process.rest_of_error().find("interrupted; resume with: coppice evolve study.coppice --resume"),
            std::string::npos);
  const auto interrupted = coppice_json({"info", "study.coppice", "--json"})["runs"].at(0);
  EXPECT_EQ(interrupted["status"], "interrupted");
  EXPECT_TRUE(interrupted["resumable"]);
  const int saved = interrupted["generations"];
  EXPECT_GE(saved, 5);
  EXPECT_EQ(coppice({"score", "study.coppice", "--episodes", "2"}).ending, kDone);

  Process resumed(command({"evolve", "study.coppice", "--serial", "--resume", "--lines-every", "1"}));
  resumed.await_error("evolve: " + std::to_string(saved + 1) + "/100000 generations");
  resumed.signal(SIGTERM);
  EXPECT_EQ(resumed.wait(), kInterrupted);
  const auto runs = coppice_json({"info", "study.coppice", "--json"})["runs"];
  ASSERT_EQ(runs.size(), 1U);
  EXPECT_GT(runs[0]["generations"], saved);
}

}  // namespace
}  // namespace coppice::e2e
