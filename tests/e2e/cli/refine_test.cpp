#include <signal.h>

#include "tests/e2e/cli/command_line.hpp"

namespace coppice::e2e {
namespace {

class Refine : public CommandLine {
 protected:
  void SetUp() override { learn_study(); }

  std::vector<std::string> refine(const std::string& folder, const std::vector<std::string>& more) const {
    std::vector<std::string> arguments = {"refine",
                                          "study.coppice",
                                          "-o",
                                          folder,
                                          "--rounds",
                                          "2",
                                          "--episodes",
                                          "30",
                                          "--score-episodes",
                                          "10",
                                          "--set",
                                          "ga.generations=6",
                                          "--set",
                                          "ga.population=30",
                                          "--seed",
                                          "4",
                                          "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }

  // Without what names the folder.
  static nlohmann::json figures(nlohmann::json report) {
    report.erase("folder");
    for (nlohmann::json& round : report["rounds"]) {
      round.erase("study");
    }
    return report;
  }
};

TEST_F(Refine, OverWorkersEqualsTheSerialOneAndLeavesTheStudyAsItWas) {
  const std::string before = read("study.coppice");
  const nlohmann::json serial = coppice_json(refine("serial", {"--tree", kWallTree, "--serial"}));
  const nlohmann::json workers = coppice_json(refine("workers", {"--tree", kWallTree, "--workers", "2"}));
  ASSERT_EQ(serial["rounds"].size(), 3U);
  EXPECT_EQ(figures(serial), figures(workers));
  EXPECT_EQ(read("study.coppice"), before);
  std::string chain = serial["rounds"][0]["chain"];
  for (std::size_t round = 1; round <= 2; ++round) {
    const nlohmann::json& ended = serial["rounds"][round];
    EXPECT_EQ(ended["study"], "serial/round-" + std::to_string(round) + ".coppice");
    EXPECT_EQ(ended["added"]["steps"], 30 * 150) << "the default tree always acts";
    EXPECT_NE(ended["chain"], chain);
    chain = ended["chain"];
    const nlohmann::json info = coppice_json({"info", ended["study"], "--json"});
    EXPECT_EQ(info["chain"], chain);
    EXPECT_EQ(info["runs"].size(), 1U);
    EXPECT_EQ(info["learning"]["outcome"]["refined"].size(), round);
  }
  EXPECT_EQ(coppice_json({"score", "serial/round-2.coppice", "--episodes", "10", "--json"})["tree"],
            serial["rounds"][2]["score"]["tree"]);
}

TEST_F(Refine, PrintsALineForEachRound) {
  const Completed completed =
      coppice({"refine", "study.coppice", "-o", "refined", "--tree", kWallTree, "--rounds", "1", "--episodes", "10",
               "--score-episodes", "5", "--serial", "--set", "ga.generations=3"});
  ASSERT_EQ(completed.ending, kDone) << completed.error;
  const auto lines = lines_of(completed.output);
  ASSERT_EQ(lines.size(), 8U) << completed.output;
  EXPECT_EQ(lines[5].rfind("best: round ", 0), 0U) << lines[5];
  EXPECT_EQ(lines[7], lines[5].rfind("best: round 0", 0) == 0 ? "its study: study.coppice"
                                                              : "its study: refined/round-1.coppice");
}

TEST_F(Refine, EvolvesAsTheRefinedRunDidUnlessItIsToldOtherwise) {
  for (const char* generations : {"7", "9"}) {
    ASSERT_EQ(coppice({"evolve", "study.coppice", "--config", "thesis", "--serial", "--seed", "3", "--set",
                       "ga.population=12", "--set", std::string("ga.generations=") + generations})
                  .ending,
              kDone);
  }
  write("five.toml", "[ga]\ngenerations = 5\n");
  const auto configuration = [&](const std::string& folder, std::vector<std::string> more) {
    std::vector<std::string> arguments = {"refine", "study.coppice", "-o", folder,     "--rounds",
                                          "1",      "--episodes",    "10", "--serial", "--score-episodes",
                                          "5"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    EXPECT_EQ(coppice(arguments).ending, kDone);
    return coppice_json({"info", folder + "/round-1.coppice", "--json"})["runs"][0]["configuration"];
  };
  const auto last = configuration("last", {});
  EXPECT_EQ(last["ga"]["generations"], 9);
  EXPECT_EQ(last["ga"]["population"], 12);
  EXPECT_EQ(last["seed"], 4) << "the run's, and one a round";
  EXPECT_EQ(configuration("first", {"--run", "1"})["ga"]["generations"], 7);
  EXPECT_EQ(configuration("given", {"--tree", kWallTree})["ga"]["generations"], 9);
  EXPECT_EQ(configuration("set", {"--set", "ga.generations=4"})["ga"]["generations"], 4);
  const auto file = configuration("file", {"--config", "five.toml"});
  EXPECT_EQ(file["ga"]["generations"], 5);
  EXPECT_NE(file["ga"]["population"], 12) << "a file starts from the defaults";
}

TEST_F(Refine, InterruptedKeepsTheRoundsBeforeAndTheBestSoFar) {
  std::vector<std::string> arguments = refine("cut", {"--tree", kWallTree, "--serial", "--lines-every", "1"});
  arguments.insert(arguments.end(), {"--set", "ga.generations=100000"});
  Process process(command(arguments));
  process.await_error("evolve: 30/100000");
  process.signal(SIGINT);
  EXPECT_EQ(process.wait(), kInterrupted);
  const auto report = nlohmann::json::parse(process.rest_of_output());
  ASSERT_EQ(report["rounds"].size(), 2U);
  EXPECT_FALSE(report["rounds"][0]["interrupted"]);
  EXPECT_TRUE(report["rounds"][1]["interrupted"]);
  const nlohmann::json info = coppice_json({"info", "cut/round-1.coppice", "--json"});
  EXPECT_EQ(info["runs"][0]["status"], "interrupted");
  EXPECT_FALSE(info["runs"][0]["tree"].is_null());
}

TEST_F(Refine, WrongUseMakesNothing) {
  expect_wrong_use({"refine", "study.coppice", "-o", "out", "--serial"}, {"study.coppice", "--tree", "coppice evolve"});
  expect_wrong_use({"refine", "none.coppice", "-o", "out", "--serial"}, {"none.coppice"});
  expect_wrong_use({"refine", "study.coppice", "-o", "out", "--serial", "--tree", kWallTree, "--rounds", "0"},
                   {"--rounds is 0", "1 to 1000"});
  expect_wrong_use({"refine", "study.coppice", "-o", "out", "--serial", "--tree", kWallTree, "--episodes", "1"},
                   {"--episodes is 1"});
  expect_wrong_use({"refine", "study.coppice", "-o", "out", "--serial", "--tree", "(selector walk)"}, {"walk"});
  expect_wrong_use({"refine", "study.coppice", "-o", "out", "--serial", "--tree", kWallTree, "--set",
                    "ga.founders=(selector move turn_left); (sequence"},
                   {"ga.founders", "tree 2"});
  EXPECT_FALSE(exists("out"));
  std::filesystem::create_directory(path("there"));
  expect_wrong_use({"refine", "study.coppice", "-o", "there", "--serial", "--tree", kWallTree},
                   {"-o: there exists already"});
  ASSERT_EQ(coppice({"synth", "-o", "made-up.coppice", "--states", "50"}).ending, kDone);
  expect_wrong_use({"refine", "made-up.coppice", "-o", "out", "--serial", "--tree", "a0"},
                   {"made-up.coppice", "no world"});
}

}  // namespace
}  // namespace coppice::e2e
