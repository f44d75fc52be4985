#include "coordinator/exchange/prism.hpp"

#include <gtest/gtest.h>

#include "tests/coordinator/exchange/sources.hpp"

namespace coppice {
namespace {

using testing::SourceFiles;

struct PrismFiles {
  std::string tra = "3 4 5\n0 0 1 0.5 go\n0 0 2 0.5 go\n0 1 0 1 stay\n1 0 2 1\n2 0 2 1\n";
  std::string sta = "(x,lit)\n0:(-1,true)\n2:(5,false)\n1:(0,true)\n";
  std::string lab = "0=\"init\" 1=\"deadlock\" 2=\"goal\"\n0: 0\n2: 1 2\n";
  std::string srew = "3 1\n1 4\n";
  std::string trew = "3 4 1\n0 0 2 10\n";

  std::string write(SourceFiles& files) const {
    files.write("m.sta", sta);
    files.write("m.lab", lab);
    files.write("m.srew", srew);
    files.write("m.trew", trew);
    return files.write("m.tra", tra);
  }
};

TEST(Prism, AnMdpIsReadWithAllItsFiles) {
  SourceFiles files;
  const auto model = read_prism(PrismFiles().write(files));
  ASSERT_TRUE(model.has_value()) << model.error().message;
  EXPECT_EQ(model->feature_names, (std::vector<std::string>{"x", "lit"}));
  EXPECT_EQ(model->readings, (std::vector<double>{-1, 1, 0, 1, 5, 0}));
  EXPECT_EQ(model->action_names, (std::vector<std::string>{"go", "stay", "choice0"}));
  EXPECT_EQ(model->reward, (std::vector<double>{5, 0, 0, 0, 0, 4, 0, 0, 0}));
  EXPECT_EQ(model->terminals, std::vector<std::uint32_t>{2});
  EXPECT_EQ(model->labels.at("goal"), std::vector<std::uint32_t>{2});
  ASSERT_EQ(model->starts.size(), 1U);
}

TEST(Prism, GainAndCostCountAgainstEachOther) {
  SourceFiles files;
  files.write("g.gain.srew", "2 1\n0 5\n");
  files.write("g.cost.srew", "2 2\n0 2\n1 1\n");
  const auto model = read_prism(files.write("g.tra", "2 2\n0 1 1\n1 0 1\n"));
  ASSERT_TRUE(model.has_value()) << model.error().message;
  EXPECT_EQ(model->reward, (std::vector<double>{3, -1}));
}

TEST(Prism, AChainAloneStartsInStateZero) {
  SourceFiles files;
  const auto model = read_prism(files.write("c.tra", "2 3\n0 0 0.25\n0 1 0.75\n1 1 1\n"));
  ASSERT_TRUE(model.has_value()) << model.error().message;
  EXPECT_EQ(model->feature_names, std::vector<std::string>{"state"});
  EXPECT_EQ(model->probability, (std::vector<double>{0.25, 0.75, 1}));
  EXPECT_EQ(model->starts[0].state, 0U);
}

TEST(Prism, WhatIsWrongIsNamedWithItsFileAndLine) {
  const auto refused = [](const PrismFiles& content, const std::string& message) {
    SourceFiles files;
    const auto model = read_prism(content.write(files));
    ASSERT_FALSE(model.has_value()) << message;
    EXPECT_NE(model.error().message.find(message), std::string::npos) << model.error().message;
  };
  refused({.tra = ""}, "expected states, choices and transitions");
  refused({.tra = "3\n"}, "m.tra: line 1: expected two numbers");
  refused({.tra = "0 0 0\n"}, "with 1 to");
  refused({.tra = "200000000 1 1\n0 0 0 1\n"}, "1 transitions for 200000000 states");
  refused({.tra = "3 4 5\n0 0 3 1\n"}, "m.tra: line 2: found '3': expected a state below 3");
  refused({.tra = "3 4 5\n0 0 1 x\n"}, "found 'x': expected a number");
  refused({.tra = "3 4 5\n0 99999999 1 1\n"}, "expected a choice below");
  refused({.tra = "3 4 5\n0 0 1 1 a b\n"}, "found 'b': expected the end of the line");
  refused({.tra = "3 4 5\n0 0 1 0.5 a\n0 0 2 0.5 b\n1 0 1 1\n2 0 2 1\n"}, "is called a and b");
  refused({.tra = "3 4 5\n0 0 1 0.5 a\n1 0 1 1\n2 0 2 1\n"}, "sum to 0.5");
  refused({.sta = "x,y\n"}, "m.sta: line 1: expected the variables");
  refused({.sta = "(x,lit)\n0:(1)\n"}, "expected 2 values");
  refused({.sta = "(x,lit)\n0:(1,true)\n"}, "state 1 is missing");
  refused({.sta = "(x,lit)\n0:(1,true)\n0:(1,true)\n"}, "state 0 for a second time");
  refused({.lab = "0=\"deadlock\"\n"}, "no state where episodes start");
  refused({.lab = "init\n"}, "m.lab: line 1: found 'init'");
  refused({.lab = "0=\"init\"\n0: 3\n"}, "expected a label below 1");
  refused({.srew = "3 1\n1 x\n"}, "m.srew: line 2");
  refused({.trew = "3 4 1\n0 0 9 1\n"}, "m.trew: line 2");
}

}  // namespace
}  // namespace coppice
