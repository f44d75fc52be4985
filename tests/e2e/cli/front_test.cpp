// The front of an evolution: listed, drawn, picked from, and what is said where nothing fits.
#include "tests/e2e/cli/evolved_study.hpp"

namespace coppice::e2e {
namespace {

class FrontCommand : public EvolvedStudy {
 protected:
  void SetUp() override {
    EvolvedStudy::SetUp();
    evolved_ = evolve_front("best return with nodes<=20");
  }

  nlohmann::json evolve_front(const std::string& rule) const {
    return coppice_json(evolve(
        "study.coppice",
        {"--serial", "--json", "--seed", "2", "--set", "ga.search=front", "--set", "ga.generations=10", "--set",
         "ga.population=40", "--set", "front.objectives=agreement, coverage, return", "--set", "front.pick=" + rule}));
  }

  nlohmann::json evolved_;
};

TEST_F(FrontCommand, ListsTreesOfWhichNoneBeatsAnother) {
  const auto front = coppice_json({"front", "study.coppice", "--json"});
  ASSERT_EQ(front.size(), evolved_["front"]);
  ASSERT_GT(front.size(), 1U);
  for (const auto& a : front) {
    for (const auto& b : front) {
      const bool beaten = a["agreement"] > b["agreement"] && a["coverage"] > b["coverage"] && a["return"] > b["return"];
      EXPECT_FALSE(beaten) << a << "\n" << b;
    }
  }
  const Completed listed = coppice({"front", "study.coppice"});
  EXPECT_EQ(lines_of(listed.output).size(), front.size() + 2) << listed.output;  // what it is, and the names
  EXPECT_NE(listed.output.find(" <\n"), std::string::npos) << listed.output;
}

TEST_F(FrontCommand, PicksByARule) {
  const auto front = coppice_json({"front", "study.coppice", "--pick", "best coverage", "-o", "best.tree", "--json"});
  double most = 0.0;
  std::string best;
  for (const auto& member : front) {
    most = std::max(most, member["coverage"].get<double>());
    best = member["picked"].get<bool>() ? member["tree"].get<std::string>() : best;
  }
  EXPECT_EQ(read("best.tree"), best + "\n");
  EXPECT_EQ(coppice({"front", "study.coppice", "--pick", "best coverage"}).output, best + "\n");
  const auto score = coppice_json({"score", "study.coppice", "--tree", "best.tree", "--episodes", "2", "--json"});
  EXPECT_DOUBLE_EQ(score["tree"]["agreement_over_states"].get<double>(), most);
}

TEST_F(FrontCommand, WalksEachTreeInTheSimulatorWhenAskedTo) {
  const auto front = coppice_json({"front", "study.coppice", "--episodes", "4", "--steps", "30", "--json"});
  for (const auto& member : front) {
    ASSERT_EQ(member["simulated"]["episodes"], 4);
  }
  const auto score = coppice_json({"score", "study.coppice", "--tree", front[0]["tree"].get<std::string>(),
                                   "--episodes", "4", "--steps", "30", "--json"});
  EXPECT_EQ(front[0]["simulated"]["reward"], score["tree"]["reward"]);
  const Completed listed = coppice({"front", "study.coppice", "--episodes", "4", "--steps", "30"});
  EXPECT_NE(listed.output.find("simulated: agreement"), std::string::npos) << listed.output;
  EXPECT_FALSE(coppice_json({"front", "study.coppice", "--json"})[0].contains("simulated"));
  expect_wrong_use({"front", "study.coppice", "--simulator", "true"}, {"--simulator without --episodes"});
}

TEST_F(FrontCommand, RefusesARuleThatNothingFits) {
  expect_wrong_use({"front", "study.coppice", "--pick", "best return with coverage>=2", "-o", "none.tree"},
                   {"--pick best return with coverage>=2", "none of the"});
  EXPECT_FALSE(exists("none.tree"));
  expect_wrong_use({"front", "study.coppice", "--pick", "best taste"}, {"--pick", "'taste'", "expected"});
}

TEST_F(FrontCommand, DrawsTwoMeasures) {
  const Completed drawn = coppice({"front", "study.coppice", "--plot", "front.svg", "--axes", "agreement,return"});
  ASSERT_EQ(drawn.ending, kDone) << drawn.error;
  const std::string svg = read("front.svg");
  EXPECT_NE(svg.find("</svg>"), std::string::npos);
  EXPECT_NE(svg.find("agreement"), std::string::npos);
  expect_wrong_use({"front", "study.coppice", "--plot", "other.svg", "--axes", "agreement"},
                   {"--axes", "two measures"});
  expect_wrong_use({"front", "study.coppice", "--plot", "other.svg", "--axes", "agreement,regret"},
                   {"--axes", "no 'regret'", "coverage"});
  expect_wrong_use({"front", "study.coppice", "--plot", "study.coppice"}, {"--plot", "study.coppice"});
  EXPECT_FALSE(exists("other.svg"));
}

TEST_F(FrontCommand, SaysThatNoTreeFitsTheRuleOfTheRun) {
  EXPECT_TRUE(evolved_["pick_fits"].get<bool>());
  EXPECT_FALSE(evolve_front("best return with coverage>=2")["pick_fits"].get<bool>());
  const Completed told = coppice(evolve(
      "study.coppice", {"--serial", "--seed", "2", "--set", "ga.search=front", "--set", "ga.generations=2", "--set",
                        "front.pick=best return with "
                        "coverage>=2"}));
  EXPECT_NE(told.output.find("no tree of the front fits front.pick 'best return with coverage>=2'"), std::string::npos)
      << told.output;
}

TEST_F(FrontCommand, NeedsARunWithAFront) {
  ASSERT_EQ(coppice({"learn", "-o", "other.coppice", "--episodes", "10"}).ending, kDone);
  expect_wrong_use({"front", "other.coppice"}, {"other.coppice", "no run has a front", "ga.search=front"});
  expect_wrong_use({"front", "study.coppice", "--run", "7"}, {"7"});
}

}  // namespace
}  // namespace coppice::e2e
