#include "coordinator/exchange/problem_file.hpp"

#include <gtest/gtest.h>

#include "coordinator/exchange/predicate.hpp"
#include "tests/coordinator/exchange/sources.hpp"

namespace coppice {
namespace {

using testing::SourceFiles;

constexpr std::string_view kFile = R"(
title = "Robot"
simulator = "python3 sim.py"
reward = "gain - cost"
discount = 0.95
no_action = "hold"
terminal = "again"
look_alikes = "merge"
without_actions = ["__random__"]
collisions = { when = "ahead=0" }
terminals = { label = "goal" }
initial = { shares = { 0 = 3, 7 = 1.5 } }

[features.ahead]
name = "front"
label = "ahead"
values = { 0 = "wall", 1 = "free", 3 = "trash" }
operators = ["="]

[features."pole angle"]
unit = "rad"
bins = [0.0419, -0.0419]

[features.speed]
bins = { quantiles = 8 }

[features.charge]
bins = { entropy = 5 }

[actions.0]
name = "left"
label = "turn left"
)";

TEST(ProblemFile, HoldsAllThatItSays) {
  SourceFiles files;
  const auto file = read_problem_file(files.write("p.toml", kFile));
  ASSERT_TRUE(file.has_value()) << file.error().message;
  EXPECT_EQ(file->title, "Robot");
  EXPECT_EQ(file->simulator, "python3 sim.py");
  EXPECT_EQ(file->reward, "gain - cost");
  EXPECT_EQ(file->discount, 0.95);
  EXPECT_EQ(file->no_action, "hold");
  EXPECT_EQ(file->terminal, WhenTerminal::again);
  EXPECT_EQ(file->look_alikes, LookAlikes::merge);
  EXPECT_EQ(file->without_actions, std::vector<std::string>{"__random__"});
  EXPECT_EQ(file->collisions.when, "ahead=0");
  EXPECT_EQ(file->terminals.label, "goal");
  EXPECT_EQ(file->initial.shares, (std::map<std::uint32_t, double>{{0, 3.0}, {7, 1.5}}));
  const FeatureWish& ahead = file->features.at("ahead");
  EXPECT_EQ(ahead.name, "front");
  EXPECT_EQ(ahead.values.at(3.0), "trash");
  EXPECT_EQ(ahead.admits_equal, true);
  EXPECT_EQ(ahead.admits_less_equal, false);
  EXPECT_EQ(file->features.at("pole angle").binning->edges, (std::vector<double>{0.0419, -0.0419}));
  EXPECT_EQ(file->features.at("speed").binning->kind, Binning::Kind::quantiles);
  EXPECT_EQ(file->features.at("charge").binning->bins, 5U);
  EXPECT_EQ(file->actions.at("0").label, "turn left");
}

TEST(ProblemFile, WhatIsWrongIsNamedWithLineAndKey) {
  SourceFiles files;
  const auto refused = [&files](const std::string& text, const std::string& message) {
    const auto file = read_problem_file(files.write("bad.toml", text));
    ASSERT_FALSE(file.has_value()) << message;
    EXPECT_NE(file.error().message.find("bad.toml: line "), std::string::npos) << file.error().message;
    EXPECT_NE(file.error().message.find(message), std::string::npos) << file.error().message;
  };
  refused("\ncolour = 1", "line 2: colour: expected one of actions, collisions, discount");
  refused("title = 1", "title: expected a text");
  refused("discount = 2", "discount: expected a number from 0 to 1");
  refused("terminal = \"stop\"", "terminal: expected \"absorb\" or \"again\"");
  refused("look_alikes = 1", "look_alikes: expected");
  refused("without_actions = [1]", "without_actions: expected a list of names");
  refused("features = 1", "features: expected a table");
  refused("features.x = 1", "features.x: expected a table");
  refused("features.x.color = 1", "features.x.color: expected one of bins, label");
  refused("features.x.bins = 3", "features.x.bins: expected a list of edges");
  refused("features.x.bins = { quantiles = 1 }", "features.x.bins: expected 2 to 255 bins");
  refused("features.x.bins = [\"a\"]", "features.x.bins: expected a number");
  refused("features.x.operators = [\"<\"]", "features.x.operators: expected a list");
  refused("features.x.values = { a = \"b\" }", "features.x.values.a: expected a number as key");
  refused("collisions = { reward = 1, when = \"x=1\" }", "collisions: expected one of");
  refused("initial = { shares = { a = 1 } }", "initial.shares.a: expected a state's number");
  refused("initial = { shares = { 1 = 0 } }", "initial.shares.1: expected a state's number and a share above 0");
  refused("title = ", "bad.toml: line 1");
  refused("title = \"x\"\n[.actions]\n", "bad.toml: line 2");
  refused("[", "bad.toml: line 1");
}

TEST(Predicate, HoldsAsItReads) {
  const std::vector<std::string> features{"x", "pole angle"};
  const auto holds = [&features](const std::string& text, double x, double angle) {
    const auto predicate = Predicate::parse(text, features);
    EXPECT_TRUE(predicate.has_value()) << text << ": " << (predicate ? "" : predicate.error().message);
    const std::vector<double> readings{x, angle};
    return predicate && predicate->holds(readings);
  };
  EXPECT_TRUE(holds("x=3", 3, 0));
  EXPECT_FALSE(holds("x!=3", 3, 0));
  EXPECT_TRUE(holds("x<3 and pole angle>=-0.5", 2, -0.5));
  EXPECT_FALSE(holds("x<3 and pole angle>-0.5", 2, -0.5));
  EXPECT_TRUE(holds(" x > 9 or x <= 2 and pole angle = 1 ", 2, 1));
  EXPECT_FALSE(holds("x > 9 or x <= 2 and pole angle = 1", 2, 0));
  for (const auto& [text, message] : std::vector<std::pair<std::string, std::string>>{
           {"", "column 1: found '': expected a feature (x, pole angle)"},
           {"y=1", "column 1: found 'y'"},
           {"x", "expected =, !=, <, <=, > or >= behind 'x'"},
           {"x=", "column 3: found '': expected a number"},
           {"x=1 or", "expected a feature"},
           {"x=1 xor x=2", "column 5: found 'xor': expected 'and', 'or' or the end"}}) {
    const auto predicate = Predicate::parse(text, features);
    ASSERT_FALSE(predicate.has_value()) << text;
    EXPECT_NE(predicate.error().message.find(message), std::string::npos) << predicate.error().message;
  }
}

}  // namespace
}  // namespace coppice
