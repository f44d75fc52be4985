// verify, explain and edit: what a tree promises, where it goes wrong, and how to change it.
#include <signal.h>

#include "tests/e2e/cli/command_line.hpp"

namespace coppice::e2e {
namespace {

class Trust : public CommandLine {
 protected:
  void SetUp() override { learn_study(); }

  nlohmann::json verified(std::vector<std::string> more, const Ending& ending = kDone) const {
    std::vector<std::string> arguments{"verify", "study.coppice", "--tree", kWallTree, "--resamples",
                                       "20",     "--episodes",    "20",     "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Completed completed = coppice(arguments);
    EXPECT_EQ(completed.ending, ending) << completed.error;
    return nlohmann::json::parse(completed.output, nullptr, false);
  }
};

TEST_F(Trust, ARuleThatHoldsIsProvedAndItsNodesAreListed) {
  const auto report = verified({"--rule", "never move when s3=0"});
  const auto& rule = report["rules"][0];
  EXPECT_EQ(rule["holds"], true);
  EXPECT_EQ(rule["nodes"].size(), 4U);
  EXPECT_EQ(rule["nodes"][3]["is"], "turn_left");
  EXPECT_EQ(rule["nodes"][3]["role"], "has the last word");
  // Without moves into walls there are no collisions, in the chain and in the room.
  EXPECT_EQ(report["events"][0]["name"], "collision");
  EXPECT_EQ(report["events"][0]["ever"]["high"], 0.0);
  EXPECT_EQ(report["simulator"]["collision"]["value"], 0.0);
  EXPECT_GT(report["events"][1]["within"]["value"], 0.0);
}

TEST_F(Trust, ARuleThatIsBrokenEndsWithOneAndNamesTheObservation) {
  write("safety.rules", "# about walls\n\nnever move when s3=0\nalways turn_left when s1=3\n");
  const auto report = verified({"--rules", "safety.rules", "--rule", "never none"}, kFailed);
  ASSERT_EQ(report["rules"].size(), 3U);
  EXPECT_EQ(report["rules"][0]["rule"], "never none");
  EXPECT_EQ(report["rules"][0]["holds"], true);
  EXPECT_EQ(report["rules"][1]["holds"], true);
  EXPECT_EQ(report["rules"][2]["holds"], false);
  EXPECT_EQ(report["rules"][2]["broken_by"]["matters"], "s1=3 s3=1");
  EXPECT_EQ(report["rules"][2]["broken_by"]["action"], "move");
  const Completed text = coppice({"verify", "study.coppice", "--tree", "move", "--rule", "never move when s3=0",
                                  "--resamples", "20", "--episodes", "20"});
  EXPECT_EQ(text.ending, kFailed);
  EXPECT_NE(text.output.find("no   never move when s3=0"), std::string::npos) << text.output;
  EXPECT_NE(text.output.find("among the states that learning met"), std::string::npos) << text.output;
  EXPECT_NE(text.error.find("breaks 1 of 1 rule"), std::string::npos) << text.error;
}

TEST_F(Trust, RulesThatTheStudyKeepsAreProvedWithoutTypingThemAgain) {
  EXPECT_EQ(verified({})["rules"].size(), 0U);
  expect_wrong_use({"verify", "study.coppice", "--tree", "move", "--keep"}, {"--keep without --rule or --rules"});
  verified({"--rule", "never move when s3=0", "--rule", "never none", "--keep"});
  verified({"--rule", "never none", "--keep"});  // is there already
  const auto kept = verified({})["rules"];
  ASSERT_EQ(kept.size(), 2U);
  EXPECT_EQ(kept[0]["rule"], "never move when s3=0");
  EXPECT_EQ(kept[0]["holds"], true);
  EXPECT_EQ(verified({"--rule", "never move when s3=1"}, kFailed)["rules"].size(), 1U) << "those given stand alone";
  const auto info = coppice_json({"info", "study.coppice", "--json"});
  EXPECT_EQ(info["rules"], (nlohmann::json{"never move when s3=0", "never none"}));
  EXPECT_NE(coppice({"info", "study.coppice"}).output.find("rules kept"), std::string::npos);
}

TEST_F(Trust, ATreeThatMovesIntoWallsCollidesForSure) {
  const Completed completed = coppice({"verify", "study.coppice", "--tree", "move", "--resamples", "20", "--json"});
  ASSERT_EQ(completed.ending, kDone) << completed.error;
  const auto report = nlohmann::json::parse(completed.output, nullptr, false);
  // It collides, or leaves the model before that: 400 episodes of learning have not tried everything.
  const double ever = report["events"][0]["ever"]["value"];
  EXPECT_GT(ever, 0.9);
  EXPECT_GE(ever + report["leaves_by_untried_pair"]["ever"]["value"].get<double>(), 1.0 - 1e-9);
  EXPECT_GT(report["events"][0]["steps"]["value"], 1.0);
  EXPECT_GT(report["simulator"]["collision"]["value"], 0.9);
}

TEST_F(Trust, EventsCanBeGivenAndTheSameSeedGivesTheSameFigures) {
  const auto report = verified({"--event", "turn:reward<=-1"});
  ASSERT_EQ(report["events"].size(), 1U);
  EXPECT_EQ(report["events"][0]["name"], "turn");
  EXPECT_EQ(report, verified({"--event", "turn:reward<=-1"}));
}

TEST_F(Trust, WrongRulesAndFlagsAreNamedWithTheirPlace) {
  const std::vector<std::string> verify{"verify", "study.coppice", "--tree", "move"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), verify.begin(), verify.end());
    return more;
  };
  write("bad.rules", "never move when s3=0\nnever fly\n");
  write("none.rules", "# nothing\n");
  expect_wrong_use(with({"--rule", "never move when s3=2"}), {"--rule", "column 20", "0, 1, 3"});
  expect_wrong_use(with({"--rules", "bad.rules"}), {"bad.rules", "line 2", "column 7", "fly"});
  expect_wrong_use(with({"--rules", "none.rules"}), {"none.rules", "no rule"});
  expect_wrong_use(with({"--event", "crash"}), {"--event", "crash", "NAME:reward<=NUMBER"});
  expect_wrong_use(with({"--resamples", "3"}), {"--resamples", "3", "20"});
  expect_wrong_use({"explain", "study.coppice", "--tree", "move", "--weights", "trees"},
                   {"--weights", "trees", "policy"});
  expect_wrong_use({"explain", "study.coppice", "--tree", "move", "--tests", "0"}, {"--tests", "0"});
  expect_wrong_use({"edit", "study.coppice", "--tree", "move", "--delete", "4"}, {"node 4", "0 to 0"});
  expect_wrong_use({"edit", "study.coppice", "--tree", "move", "--replace", "0 fly"}, {"--replace", "fly"});
  expect_wrong_use({"edit", "study.coppice", "--tree", "move", "-o", "study.coppice"}, {"study.coppice"});
}

TEST_F(Trust, AnInterruptionEndsVerifying) {
  Process process(command({"verify", "study.coppice", "--tree", kWallTree, "--resamples", "100000"}));
  process.await_blocked(SIGTERM);
  process.signal(SIGTERM);
  EXPECT_EQ(process.wait(), kInterrupted);
  EXPECT_NE(process.rest_of_error().find("interrupted"), std::string::npos);
}

TEST_F(Trust, WhatExplainSuggestsEditAppliesAndItSavesWhatItSays) {
  const auto report = coppice_json({"explain", "study.coppice", "--tree", kWallTree, "--groups", "1", "--json"});
  EXPECT_GT(report["cost"], 0.0);
  EXPECT_GE(report["costliest"][0]["cost"], report["costliest"][1]["cost"]);
  ASSERT_EQ(report["groups"].size(), 1U);
  const auto& group = report["groups"][0];
  const std::string edit = group["edit"];  // --insert '0 0 (sequence ...)'
  const std::size_t quote = edit.find('\'');
  ASSERT_EQ(edit.substr(0, quote), "--insert ");
  const auto edited = coppice_json({"edit", "study.coppice", "--tree", kWallTree, "--insert",
                                    edit.substr(quote + 1, edit.size() - quote - 2), "--episodes", "20", "-o",
                                    "better.tree", "--json"});
  EXPECT_EQ(edited["after"]["tree"], group["tree"]);
  EXPECT_EQ(edited["after"]["reward_along_chain"], group["alone"]["reward_along_chain"]);
  EXPECT_EQ(read("better.tree"), edited["after"]["tree"].get<std::string>() + "\n");
  // All states weighing the same, what is left to pay is exactly what was not saved.
  const auto cost_of = [&](const std::string& tree) {
    return coppice_json({"explain", "study.coppice", "--tree", tree, "--groups", "1", "--weights", "states", "--json"});
  };
  const auto before = cost_of(kWallTree);
  const auto after = cost_of(before["groups"][0]["tree"]);
  EXPECT_NEAR(after["cost"].get<double>(), before["cost"].get<double>() - before["groups"][0]["saved"].get<double>(),
              1e-6);
}

TEST_F(Trust, EditWithoutAChangeShowsTheNumberedTree) {
  const Completed shown = coppice({"edit", "study.coppice", "--tree", kWallTree, "--episodes", "20"});
  EXPECT_EQ(shown.ending, kDone) << shown.error;
  EXPECT_EQ(shown.output.rfind("  0  selector\n  1    sequence\n  2      s3=0                      ahead is wall\n"
                               "  3      turn_left\n  4    move\n",
                               0),
            0U)
      << shown.output;
  EXPECT_EQ(files(), std::vector<std::string>{"study.coppice"});
}

TEST_F(Trust, AMadeUpChainHasNoSimulatorAndIsVerifiedAllTheSame) {
  ASSERT_EQ(coppice({"synth", "-o", "s.coppice", "--states", "500"}).ending, kDone);
  const auto info = coppice_json({"info", "s.coppice", "--json"});
  const std::string action = info["actions"][0];
  const auto report = coppice_json({"verify", "s.coppice", "--tree", action, "--rule", "always " + action, "--event",
                                    "rich:reward>=0", "--resamples", "20", "--json"});
  EXPECT_FALSE(report.contains("simulator"));
  EXPECT_EQ(report["rules"][0]["holds"], true);
  EXPECT_EQ(coppice({"edit", "s.coppice", "--tree", action}).ending, kDone);
}

}  // namespace
}  // namespace coppice::e2e
