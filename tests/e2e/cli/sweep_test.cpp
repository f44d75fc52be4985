#include "tests/e2e/cli/command_line.hpp"

namespace coppice::e2e {
namespace {

class Sweep : public CommandLine {
 protected:
  void SetUp() override {
    learn_study();
    write("sweep.toml",
          "seeds = 3\nepisodes = 4\n[set]\nga.generations = 6\nga.population = 30\n"
          "[grid]\nrollout.acting = [\"tree\", \"policy\"]\n");
  }

  // The rows of runs.csv without the seconds that each took.
  std::vector<std::string> runs(const std::string& folder) const {
    std::vector<std::string> rows = lines_of(read(folder + "/runs.csv"));
    for (std::string& row : rows) {
      const std::size_t seconds = column(row, kSecondsColumn);
      row.erase(seconds, row.find(',', seconds) - seconds);
    }
    return rows;
  }
  static constexpr int kSecondsColumn = 8;
  static std::size_t column(const std::string& row, int number) {
    std::size_t begin = 0;
    for (int i = 0; i < number; ++i) {
      begin = row.find(',', begin) + 1;
    }
    return begin;
  }
};

TEST_F(Sweep, OverWorkersEqualsTheSerialOneAndTheRunsAlone) {
  const Completed serial = coppice({"sweep", "study.coppice", "--config", "sweep.toml", "-o", "serial", "--serial"});
  ASSERT_EQ(serial.ending, kDone) << serial.error;
  const Completed workers =
      coppice({"sweep", "study.coppice", "--config", "sweep.toml", "-o", "workers", "--workers", "2"});
  ASSERT_EQ(workers.ending, kDone) << workers.error;
  EXPECT_EQ(runs("serial"), runs("workers"));
  EXPECT_EQ(runs("serial").size(), 7U);
  for (const char* file : {"workers/settings.csv", "workers/sweep.svg", "workers/runs.jsonl"}) {
    EXPECT_TRUE(exists(file)) << file;
  }
  EXPECT_NE(read("workers/sweep.svg").find("rollout.acting=policy"), std::string::npos);
  EXPECT_NE(workers.output.find("rollout.acting=policy     3"), std::string::npos) << workers.output;

  const auto alone =
      coppice_json({"evolve", "study.coppice", "--serial", "--config", "thesis", "--set", "ga.generations=6", "--set",
                    "ga.population=30", "--set", "rollout.acting=policy", "--seed", "2", "--json"});
  EXPECT_NE(read("serial/runs.csv").find(alone["pruned"].get<std::string>()), std::string::npos);
}

TEST_F(Sweep, GoesOnFromTheRunsThatHaveEnded) {
  ASSERT_EQ(coppice({"sweep", "study.coppice", "--config", "sweep.toml", "-o", "whole", "--serial"}).ending, kDone);
  std::filesystem::create_directory(path("part"));
  const auto lines = lines_of(read("whole/runs.jsonl"));
  ASSERT_EQ(lines.size(), 6U);
  write("part/runs.jsonl", lines[4] + "\n" + lines[1] + "\n" + lines[2].substr(0, 50));
  expect_wrong_use({"sweep", "study.coppice", "--config", "sweep.toml", "-o", "part", "--serial"},
                   {"-o: part exists already", "--resume"});
  const Completed resumed =
      coppice({"sweep", "study.coppice", "--config", "sweep.toml", "-o", "part", "--serial", "--resume"});
  ASSERT_EQ(resumed.ending, kDone) << resumed.error;
  EXPECT_EQ(runs("part"), runs("whole"));
  EXPECT_EQ(lines_of(read("part/runs.jsonl")).size(), 7U);  // with the one that was cut short
}

TEST_F(Sweep, DoesNotGoOnInTheFolderOfAnotherSweepAndLeavesItsTablesAlone) {
  ASSERT_EQ(coppice({"sweep", "study.coppice", "--config", "sweep.toml", "-o", "swept", "--serial"}).ending, kDone);
  const std::string tables = read("swept/settings.csv") + read("swept/runs.csv");
  write("other.toml", "seeds = 3\nepisodes = 4\n[set]\nga.generations = 5\n");
  expect_wrong_use({"sweep", "study.coppice", "--config", "other.toml", "-o", "swept", "--serial", "--resume"},
                   {"swept/runs.jsonl: line 1", "a run that this sweep does not have"});
  EXPECT_EQ(read("swept/settings.csv") + read("swept/runs.csv"), tables);
  write("more.toml",
        "seeds = 4\nepisodes = 4\n[set]\nga.generations = 6\nga.population = 30\n"
        "[grid]\nrollout.acting = [\"tree\", \"policy\"]\n");
  const Completed more =
      coppice({"sweep", "study.coppice", "--config", "more.toml", "-o", "swept", "--serial", "--resume"});
  ASSERT_EQ(more.ending, kDone) << more.error;
  EXPECT_EQ(runs("swept").size(), 9U);
}

TEST_F(Sweep, RefusesWhatIsWrongBeforeItMakesAFolder) {
  write("wrong.toml", "seeds = 3\n[grid]\nga.population = [1]\n");
  expect_wrong_use({"sweep", "study.coppice", "--config", "wrong.toml", "-o", "folder", "--serial"},
                   {"wrong.toml: line 3", "ga.population"});
  EXPECT_FALSE(exists("folder"));
}

}  // namespace
}  // namespace coppice::e2e
