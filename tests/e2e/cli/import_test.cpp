// coppice import, from another tool's file to a tree.
#include <cmath>

#include "tests/e2e/cli/command_line.hpp"

namespace coppice::e2e {
namespace {

// A corridor of five places: right costs 1 a step and slips one time in four; the last place ends it with a gain of 10.
constexpr const char* kCorridor = R"(@type: MDP
@parameters

@reward_models
reward
@nr_states
5
@nr_choices
9
@model
state 0 [0] init
//[place=0]
	action right [-1]
		0 : 0.25
		1 : 0.75
	action left [-1]
		0 : 1
state 1 [0]
//[place=1]
	action right [-1]
		1 : 0.25
		2 : 0.75
	action left [-1]
		0 : 1
state 2 [0]
//[place=2]
	action right [-1]
		2 : 0.25
		3 : 0.75
	action left [-1]
		1 : 1
state 3 [0]
//[place=3]
	action right [6.5]
		3 : 0.25
		4 : 0.75
	action left [-1]
		2 : 1
state 4 [0]
//[place=4]
	action right [0]
		4 : 1
)";

using ImportCommand = CommandLine;

TEST_F(ImportCommand, AModelBecomesAStudyWhosePolicyIsTheBest) {
  write("corridor.drn", kCorridor);
  const auto report =
      coppice_json({"import", "corridor.drn", "-o", "c.coppice", "--solve", "--gamma", "0.9", "--json"});
  // V(s) = r + 0.9 (0.25 V(s) + 0.75 V(s + 1)) from the last place back.
  double value = 0.0;
  for (const double reward : {6.5, -1.0, -1.0, -1.0}) {
    value = (reward + 0.9 * 0.75 * value) / (1.0 - 0.9 * 0.25);
  }
  EXPECT_NEAR(report["value"].get<double>(), value, 1e-9);
  EXPECT_LT(std::abs(report["count_error"].get<double>()), 1e-9);
  EXPECT_EQ(report["states"], 5);
  EXPECT_EQ(report["transitions"], 14);
  const auto info = coppice_json({"info", "c.coppice", "--json"});
  EXPECT_EQ(info["world"], "imported");
  EXPECT_EQ(info["terminal_states"], 1);
  EXPECT_EQ(info["no_action"], "worst");
  EXPECT_EQ(info["source"], "corridor.drn (Storm DRN)");
  const Completed evolved =
      coppice({"evolve", "c.coppice", "--serial", "--config", "thesis", "--set", "ga.generations=20"});
  EXPECT_EQ(evolved.ending, kDone) << evolved.error;
  const Completed score = coppice({"score", "c.coppice", "--tree", "right"});
  EXPECT_EQ(score.ending, kBadInput) << "nothing to simulate";
}

TEST_F(ImportCommand, AProblemFileAndFlagsAreHeeded) {
  write("corridor.drn", kCorridor);
  write("p.toml", "title = \"Corridor\"\ndiscount = 0.5\n[features.place]\nunit = \"m\"\nvalues = { 0 = \"start\" }\n");
  const auto report = coppice_json({"import", "corridor.drn", "-o", "c.coppice", "--solve", "--problem", "p.toml",
                                    "--no-action", "left", "--again", "--json"});
  EXPECT_EQ(report["discount"], 0.5);
  const auto info = coppice_json({"info", "c.coppice", "--json"});
  EXPECT_EQ(info["title"], "Corridor");
  EXPECT_EQ(info["no_action"], "left");
  expect_wrong_use({"import", "corridor.drn", "-o", "d.coppice", "--solve", "--gamma", "0.9", "--without", "up"},
                   {"no action 'up' to leave out: expected one of right, left"});
  expect_wrong_use({"import", "corridor.drn", "-o", "d.coppice", "--gamma", "0.9"}, {"expected --solve with --gamma"});
  expect_wrong_use({"import", "corridor.drn", "-o", "c.coppice", "--solve", "--gamma", "0.9"}, {"exists already"});
  expect_wrong_use({"import", "nowhere.drn", "-o", "d.coppice"}, {"nowhere.drn: cannot be opened"});
  write("odd.txt", "hello\n");
  expect_wrong_use({"import", "odd.txt", "-o", "d.coppice"}, {"odd.txt: line 1: no format is known that begins so"});
  write("bad.toml", "colour = 1\n");
  expect_wrong_use({"import", "corridor.drn", "-o", "d.coppice", "--problem", "bad.toml"},
                   {"bad.toml: line 1: colour"});
  EXPECT_EQ(files(), (std::vector<std::string>{"bad.toml", "c.coppice", "corridor.drn", "odd.txt", "p.toml"}));
}

TEST_F(ImportCommand, ALogOfContinuousReadingsGivesTreesInTheirOwnUnit) {
  std::string log = "angle,action,reward,next_angle\n";
  for (int i = 0; i < 2000; ++i) {
    const double angle = (i % 401 - 200) / 1000.0;
    log += std::to_string(angle) + "," + (angle <= 0.0415 ? "left" : "right") + ",1," + std::to_string(-angle) + "\n";
  }
  write("log.csv", log);
  const auto report = coppice_json({"import", "log.csv", "-o", "pole.coppice", "--gamma", "0.9", "--json"});
  EXPECT_EQ(report["steps"], 2000);
  EXPECT_LT(report["bin_disagreement"].get<double>(), 0.01);
  const auto evaluated = coppice({"prune", "pole.coppice", "--tree", "(selector (sequence angle<=0.0415 left) right)"});
  EXPECT_EQ(evaluated.ending, kDone) << evaluated.error;
  EXPECT_NE(evaluated.output.find("angle<=0.0415"), std::string::npos) << evaluated.output;
}

TEST_F(ImportCommand, VerifySaysHowFarATreeIsFromTheBestOfItsSize) {
  write("corridor.drn", kCorridor);
  const auto imported =
      coppice_json({"import", "corridor.drn", "-o", "c.coppice", "--solve", "--gamma", "0.9", "--json"});
  const auto verified = [&](const char* tree) {
    return coppice_json({"verify", "c.coppice", "--tree", tree, "--resamples", "20", "--json"})["of_its_size"];
  };
  const auto right = verified("right");
  EXPECT_EQ(right["conditions"], 0);
  EXPECT_EQ(right["closed"], true);
  EXPECT_EQ(right["tree_is_best"], true);
  EXPECT_NEAR(right["tree"].get<double>(), imported["value"].get<double>(), 1e-6);
  const auto left = verified("left");
  EXPECT_EQ(left["tree_is_best"], false);
  EXPECT_NEAR(left["most"].get<double>(), right["tree"].get<double>(), 1e-6) << "an action alone may earn that";
  EXPECT_NEAR(left["tree"].get<double>(), -10.0, 1e-6) << "-1 a step for ever, discounted by 0.9";
  const Completed text = coppice({"verify", "c.coppice", "--tree", "right", "--resamples", "20"});
  EXPECT_NE(text.output.find("no tree of 0 conditions earns more: proved over all 1 sets"), std::string::npos)
      << text.output;
}

}  // namespace
}  // namespace coppice::e2e
