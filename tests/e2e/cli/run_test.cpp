#include <regex>

#include "tests/e2e/cli/command_line.hpp"

namespace coppice::e2e {
namespace {

class Run : public CommandLine {
 protected:
  std::vector<std::string> small(std::vector<std::string> more) const {
    std::vector<std::string> arguments = {"run",      "--config",         "thesis", "--episodes", "400",
                                          "--serial", "--score-episodes", "5",      "--set",      "ga.generations=10",
                                          "--set",    "ga.population=30"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
};

TEST_F(Run, MakesAFolderWithStudyDrawingsAndTable) {
  const Completed completed = coppice(small({"-o", "first"}));
  ASSERT_EQ(completed.ending, kDone) << completed.error;
  for (const char* file : {"study.coppice", "evolved.svg", "evolved.dot", "pruned.svg", "pruned.dot", "table-iv.txt",
                           "table-iv.json", "report.html"}) {
    EXPECT_TRUE(exists(std::string("first/") + file)) << file;
  }
  EXPECT_NE(completed.output.find(read("first/table-iv.txt")), std::string::npos) << completed.output;
  const auto table = nlohmann::json::parse(read("first/table-iv.json"));
  EXPECT_NE(completed.output.find("evolved, " + table["nodes"]["tree"].dump() + " nodes:\n" +
                                  table["tree_text"].get<std::string>()),
            std::string::npos)
      << completed.output;
  EXPECT_NE(completed.output.find("first/pruned.svg"), std::string::npos);
  EXPECT_NE(completed.output.find("study: first/study.coppice"), std::string::npos);
  EXPECT_TRUE(completed.output.ends_with("report, to open in a browser: first/report.html\n")) << completed.output;
}

TEST_F(Run, IsTheSameAsItsParts) {
  const auto whole = coppice_json(small({"-o", "whole", "--seed", "4", "--json"}));
  ASSERT_EQ(coppice({"learn", "-o", "s.coppice", "--episodes", "400", "--seed", "4"}).ending, kDone);
  const auto evolved = coppice_json({"evolve", "s.coppice", "--serial", "--config", "thesis", "--seed", "4", "--set",
                                     "ga.generations=10", "--set", "ga.population=30", "--json"});
  const auto score = coppice_json({"score", "s.coppice", "--episodes", "5", "--seed", "4", "--json"});
  EXPECT_EQ(whole["evolve"]["tree"], evolved["tree"]);
  EXPECT_EQ(whole["evolve"]["fitness"], evolved["fitness"]);
  EXPECT_EQ(whole["score"], score);
}

TEST_F(Run, UnlessToldOtherwiseGivesAGuardedTreeChosenByWhatItIsWorthInTheSimulator) {
  const auto report = coppice_json({"run", "--episodes", "2000", "--serial", "--score-episodes", "20", "--set",
                                    "ga.generations=4", "--set", "ga.population=60", "-o", "best", "--json"});
  const auto& answer = report["evolve"]["answer"];
  EXPECT_EQ(answer["prefer"], "balance");
  EXPECT_TRUE(answer["simulated"]);
  EXPECT_GT(answer["tried"], 1);
  EXPECT_GT(answer["episodes"], 0);
  const auto run = coppice_json({"info", "best/study.coppice", "--json"})["runs"].at(0);
  EXPECT_EQ(run["configuration"]["ga"]["form"], "guarded");
  EXPECT_EQ(run["tree"], report["evolve"]["tree"]);
}

TEST_F(Run, NeverOverwrites) {
  ASSERT_EQ(coppice(small({"-o", "first"})).ending, kDone);
  const std::string before = read("first/study.coppice");
  expect_wrong_use(small({"-o", "first"}), {"first", "exists already"});
  EXPECT_EQ(read("first/study.coppice"), before);
}

TEST_F(Run, NamesItsFolderByTheTime) {
  ASSERT_EQ(coppice(small({})).ending, kDone);
  ASSERT_EQ(coppice(small({})).ending, kDone);
  const auto names = files();
  ASSERT_EQ(names.size(), 2U);
  for (const std::string& name : names) {
    EXPECT_TRUE(std::regex_match(name, std::regex("coppice-run-[0-9]{8}T[0-9]{6}Z(-2)?"))) << name;
  }
}

TEST_F(Run, WrongFlagsLeaveNoFolder) {
  expect_wrong_use(small({"-o", "first", "--alpha", "-1"}), {"--alpha"});
  expect_wrong_use(small({"-o", "first", "--set", "ga.x=1"}), {"--set", "ga.x=1"});
  expect_wrong_use({"run", "-o", "first", "--workers", "0"}, {"--workers", "1 to 1024"});
  expect_wrong_use({"run", "-o", "first", "--serial", "--score-episodes", "0"}, {"--score-episodes"});
  expect_wrong_use({"run", "-o", "first", "--remote", "--interface", "nope"}, {"--interface", "nope"});
  EXPECT_TRUE(files().empty());
}

}  // namespace
}  // namespace coppice::e2e
