#include <signal.h>

#include "tests/e2e/cli/command_line.hpp"

namespace coppice::e2e {
namespace {

class Evaluate : public CommandLine {
 protected:
  void SetUp() override { learn_study(); }

  std::vector<nlohmann::json> answers(std::vector<std::string> arguments, std::string_view input) const {
    const Completed completed = coppice(std::move(arguments), input);
    EXPECT_EQ(completed.ending, kDone) << completed.error;
    std::vector<nlohmann::json> result;
    for (const std::string& line : lines_of(completed.output)) {
      result.push_back(nlohmann::json::parse(line));
    }
    return result;
  }
};

TEST_F(Evaluate, AnswersEveryTreeInOrderWithEveryObjective) {
  const auto result = answers({"evaluate", "study.coppice", "--serial", "--rollouts", "3", "--steps", "50",
                               "--objective", "coverage", "--objective", "return"},
                              "move\n# a comment\n" + kWallTree + "\n(sequence s3=0 s3=1)\n");
  ASSERT_EQ(result.size(), 3U);
  EXPECT_EQ(result[0]["nodes"], 1);
  EXPECT_EQ(result[1]["nodes"], 5);
  EXPECT_EQ(result[2]["nodes"], 3);
  EXPECT_EQ(result[2]["matches"], 0);
  for (const auto& answer : result) {
    EXPECT_EQ(answer["steps"], 150);
    EXPECT_DOUBLE_EQ(answer["agreement"].get<double>(), answer["matches"].get<double>() / 150.0);
    EXPECT_EQ(answer["objectives"].size(), 2U);
    EXPECT_EQ(answer["objectives"]["coverage"]["value"], answer["objectives"]["coverage"]["score"]);
  }
}

TEST_F(Evaluate, CoverageIsWhatScoreCallsMatchingStates) {
  const auto result = answers({"evaluate", "study.coppice", "--serial", "--objective", "coverage"}, kWallTree + "\n");
  const auto score = coppice_json({"score", "study.coppice", "--tree", kWallTree, "--episodes", "2", "--json"});
  ASSERT_EQ(result.size(), 1U);
  EXPECT_EQ(result[0]["objectives"]["coverage"]["score"], score["tree"]["matching_states"]);
}

TEST_F(Evaluate, AFileAndAPipeAndWorkersGiveTheSameBytes) {
  const std::string trees = "move\n" + kWallTree + "\nturn_left\n";
  write("trees.txt", trees);
  const std::vector<std::string> common = {"--rollouts", "4",     "--seed",         "9",
                                           "--acting",   "mixed", "--policy-share", "0.5"};
  const auto evaluate = [&](std::vector<std::string> arguments, std::string_view input) {
    arguments.insert(arguments.end(), common.begin(), common.end());
    const Completed completed = coppice(std::move(arguments), input);
    EXPECT_EQ(completed.ending, kDone) << completed.error;
    return completed.output;
  };
  const std::string piped = evaluate({"evaluate", "study.coppice", "--serial"}, trees);
  EXPECT_EQ(lines_of(piped).size(), 3U);
  EXPECT_EQ(evaluate({"evaluate", "study.coppice", "--serial", "--trees", "trees.txt"}, ""), piped);
  EXPECT_EQ(evaluate({"evaluate", "study.coppice", "--workers", "2"}, trees), piped);
}

TEST_F(Evaluate, WhatIsComputedNeedsNoWalksAndIsTheSameOnWorkers) {
  const std::string trees = kWallTree + "\nmove\n";
  const auto values = [&](std::vector<std::string> more) {
    std::vector<std::string> arguments = {"evaluate", "study.coppice", "--objective",
                                          "return",   "--objective",   "coverage"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return answers(arguments, trees);
  };
  for (const std::vector<std::string>& method :
       {std::vector<std::string>{"--exact"}, {"--discounted", "0.95"}, {"--long-run"}}) {
    const auto with = [&](std::vector<std::string> more) {
      more.insert(more.end(), method.begin(), method.end());
      return values(more);
    };
    const auto serial = with({"--serial", "--steps", "50"});
    ASSERT_EQ(serial.size(), 2U);
    EXPECT_EQ(serial, with({"--workers", "2", "--steps", "50", "--seed", "8"})) << method[0];
    EXPECT_NE(serial[0], serial[1]) << method[0];
    EXPECT_FALSE(serial[0]["objectives"]["coverage"].contains("per_step"));
  }
  const auto exact = values({"--serial", "--exact", "--steps", "50"});
  const auto walked = values({"--serial", "--rollouts", "20000", "--steps", "50"});
  for (std::size_t i = 0; i < exact.size(); ++i) {
    EXPECT_NEAR(exact[i]["agreement"].get<double>(), walked[i]["agreement"].get<double>(), 0.01);
    EXPECT_NEAR(exact[i]["objectives"]["return"]["per_step"].get<double>(),
                walked[i]["objectives"]["return"]["per_step"].get<double>(), 0.05);
  }
  const auto score = coppice_json(
      {"score", "study.coppice", "--exact", "--steps", "50", "--episodes", "2", "--tree", kWallTree, "--json"});
  EXPECT_NEAR(score["exact"]["tree"]["agreement"].get<double>(), exact[0]["agreement"].get<double>(), 1e-6);
  EXPECT_NEAR(score["exact"]["tree"]["reward"].get<double>(),
              50 * exact[0]["objectives"]["return"]["per_step"].get<double>(), 1e-3);
  EXPECT_NEAR(score["exact"]["policy"]["agreement"].get<double>(), 1.0, 1e-12);
  expect_wrong_use({"evaluate", "study.coppice", "--serial", "--discounted", "1"}, {"--discounted", "0.999999"});
  expect_wrong_use({"evaluate", "study.coppice", "--serial", "--exact", "--long-run"}, {"--exact", "--long-run"});
}

TEST_F(Evaluate, SeedAndGenerationNameTheWalks) {
  const auto matches = [&](const char* seed, const char* generation) {
    return answers({"evaluate", "study.coppice", "--serial", "--rollouts", "50", "--seed", seed, "--generation",
                    generation},
                   kWallTree + "\n")
        .at(0)["matches"];
  };
  EXPECT_EQ(matches("1", "0"), matches("1", "0"));
  EXPECT_NE(matches("1", "0"), matches("2", "0"));
  EXPECT_NE(matches("1", "0"), matches("1", "1"));
}

TEST_F(Evaluate, MoreTreesThanOneChunkAreAnsweredInOrder) {
  std::string trees;
  for (int i = 0; i < 2500; ++i) {
    trees += i % 3 == 0 ? "move\n" : i % 3 == 1 ? kWallTree + "\n" : "(sequence move turn_left)\n";
  }
  const auto result = answers({"evaluate", "study.coppice", "--serial", "--rollouts", "1", "--steps", "5"}, trees);
  ASSERT_EQ(result.size(), 2500U);
  for (std::size_t i = 0; i < result.size(); ++i) {
    ASSERT_EQ(result[i]["nodes"], i % 3 == 0 ? 1 : i % 3 == 1 ? 5 : 3) << i;
  }
}

TEST_F(Evaluate, AnEmptyLineAsksForTheAnswersNow) {
  Process process(command({"evaluate", "study.coppice", "--serial"}));
  process.write_input("move\n" + kWallTree + "\n\n");
  const auto first = process.read_output_line();
  const auto second = process.read_output_line();
  ASSERT_TRUE(first && second) << process.rest_of_error();
  EXPECT_EQ(nlohmann::json::parse(*second)["nodes"], 5);
  process.write_input("turn_left\n");
  process.close_input();
  EXPECT_TRUE(process.read_output_line());
  EXPECT_EQ(process.wait(), kDone);
}

TEST_F(Evaluate, AMalformedLineIsNamedBeforeAnyTreeIsEvaluated) {
  expect_wrong_use({"evaluate", "study.coppice", "--serial"}, {"standard input", "line 3", "bad"},
                   "move\nmove\nbad\nmove\n");
  write("trees.txt", "move\n(selector)\n");
  expect_wrong_use({"evaluate", "study.coppice", "--serial", "--trees", "trees.txt"}, {"trees.txt", "line 2"});
  expect_wrong_use({"evaluate", "study.coppice", "--serial", "--trees", "missing.txt"}, {"--trees", "missing.txt"});
  expect_wrong_use({"evaluate", "study.coppice", "--serial", "--objective", "beauty"}, {"--objective", "beauty"});
  expect_wrong_use({"evaluate", "study.coppice", "--serial", "--acting", "nobody"}, {"--acting", "nobody"});
  expect_wrong_use({"evaluate", "study.coppice", "--serial", "--policy-share", "1.5"}, {"--policy-share", "1.5"});
  expect_wrong_use({"evaluate", "study.coppice", "--serial", "--generation", "4294967295"}, {"--generation"});
}

TEST_F(Evaluate, ALineWithoutEndIsRefusedWithoutFillingMemory) {
  expect_wrong_use({"evaluate", "study.coppice", "--serial"}, {"line 1", "characters"},
                   std::string(3U << 20U, ' ') + "move\n");
}

TEST_F(Evaluate, ASignalEndsTheWaitForMoreTrees) {
  Process process(command({"evaluate", "study.coppice", "--serial"}));
  process.write_input("move\n\n");
  ASSERT_TRUE(process.read_output_line());
  process.signal(SIGTERM);
  EXPECT_EQ(process.wait(), kInterrupted);
  EXPECT_NE(process.rest_of_error().find("interrupted"), std::string::npos);
}

}  // namespace
}  // namespace coppice::e2e
