#include "coordinator/exchange/p_tables.hpp"

#include <gtest/gtest.h>

#include "coordinator/exchange/import_source.hpp"
#include "tests/coordinator/exchange/sources.hpp"

namespace coppice {
namespace {

using testing::SourceFiles;

// State 1 ends episodes when it is reached from 0 by "jump", and is passed through by "walk".
constexpr std::string_view kTables = R"({
  "discount": 0.5, "features": ["place", {"name": "lit", "values": {"1": "bright"}}], "format": "coppice-tables-1",
  "P": [[[[0.5, 1, 4.0, true], [0.25, 1, 0, true], [0.25, 0, -1, false]], [[1.0, 1, 0, false]]],
        [[[1, 2, 10, true]], []],
        [[[1, 0, 100, false]], [[1, 2, 100, false]]],
        [[[1, 3, 5, false]], [[1, 0, 5, false]]]],
  "observations": [[0, true], [1, false], [2, true], [3, false]],
  "initial": [1, 0, 0, 0], "actions": ["jump", "walk"]})";

TEST(PTables, ATerminatedStepLeadsToAnEndOfItsOwnAndNeverFurther) {
  SourceFiles files;
  const auto tables = read_p_tables(files.write("p.json", kTables), std::nullopt);
  ASSERT_TRUE(tables.has_value()) << tables.error().message;
  const Model& model = tables->model;
  EXPECT_EQ(model.states(), 5U);
  EXPECT_EQ(model.terminals, (std::vector<std::uint32_t>{2, 4}));  // 2 is reached by ends only; 4 is the end in state 1
  EXPECT_EQ(model.source_of(4), 1U);
  EXPECT_EQ(model.readings_of(4)[0], 1.0);
  EXPECT_EQ(model.successor[0], 0U);
  EXPECT_EQ(model.successor[1], 4U);
  EXPECT_EQ(model.probability[1], 0.75);
  EXPECT_EQ(model.reward[0], 0.5 * 4.0 - 0.25);
  EXPECT_EQ(model.row_begin[4], model.row_begin[3] + 0U);  // state 1 lacks "walk"
  EXPECT_EQ(tables->header.discount, 0.5);
}

TEST(PTables, AreSolvedWhereverTheyComeFromAsTheyAre) {
  SourceFiles files;
  ImportSettings settings;
  settings.source = files.write("p.json", kTables);
  settings.solve = true;
  const auto imported = import_source(settings);
  ASSERT_TRUE(imported.has_value()) << imported.error().message;
  // walk, then jump: 0.5 x 10; or jump: V = 1.75 + 0.5 x 0.25 V = 2.
  EXPECT_NEAR(*imported->report.value, 5.0, 1e-9);
  EXPECT_EQ(imported->report.unreachable_states, 1U);
  EXPECT_EQ(imported->chain.states(), 4U);
  EXPECT_EQ(imported->problem.discount, 0.5);
  EXPECT_EQ(imported->problem.features[1].values.at(1), "bright");
  EXPECT_TRUE(imported->chain.is_forbidden(1, 1));
  EXPECT_EQ(imported->chain.parts().no_action.kind, NoAction::Kind::worst);
}

TEST(PTables, BareTablesAsListsOrByNumberAreTheSame) {
  SourceFiles files;
  const auto list = read_p_tables(files.write("l.json", "[[[[1,1,2,false]]],[[[1,0,0,true]]]]"), std::nullopt);
  const auto object =
      read_p_tables(files.write("o.json", R"({"0":{"0":[[1,1,2,false]]},"1":{"0":[[1,0,0,true]]}})"), std::nullopt);
  ASSERT_TRUE(list.has_value()) << list.error().message;
  ASSERT_TRUE(object.has_value()) << object.error().message;
  EXPECT_EQ(list->model.successor, object->model.successor);
  EXPECT_EQ(list->model.reward, object->model.reward);
  EXPECT_EQ(list->model.terminals, object->model.terminals);
}

TEST(PTables, LakesAreTheSameAsStormsToAllPrintedDigits) {
  SourceFiles files;
  for (const auto& map : {testing::kLake4, testing::kLake8}) {
    ImportSettings settings;
    settings.solve = true;
    settings.gamma = 0.99;
    settings.source = files.write("lake.json", testing::lake_tables(map));
    const auto tables = import_source(settings);
    ASSERT_TRUE(tables.has_value()) << tables.error().message;
    settings.source = files.write("lake.drn", testing::lake_drn(map));
    const auto drn = import_source(settings);
    ASSERT_TRUE(drn.has_value()) << drn.error().message;
    EXPECT_NEAR(*tables->report.value, *drn->report.value, 1e-9);
    EXPECT_EQ(tables->chain.parts().successor, drn->chain.parts().successor);
    EXPECT_EQ(tables->chain.parts().count, drn->chain.parts().count);
  }
}

TEST(PTables, CollisionsAreCountedByTheRewardOfTheSingleStep) {
  SourceFiles files;
  const auto tables = read_p_tables(files.write("p.json", kTables), -1.0);
  ASSERT_TRUE(tables.has_value()) << tables.error().message;
  EXPECT_EQ(tables->model.collision[0], 0.25);
  EXPECT_EQ(tables->model.collision[1], 0.0);
}

TEST(PTables, WhatIsWrongIsNamed) {
  SourceFiles files;
  const auto refused = [&files](std::string_view text, const std::string& message) {
    const auto tables = read_p_tables(files.write("bad.json", text), std::nullopt);
    ASSERT_FALSE(tables.has_value()) << message;
    EXPECT_NE(tables.error().message.find("bad.json"), std::string::npos);
    EXPECT_NE(tables.error().message.find(message), std::string::npos) << tables.error().message;
  };
  refused("", "parse error");
  refused("{}", "no tables");
  refused("[", "parse error");
  refused(R"({"P":7})", "\"P\": expected a list");
  refused(R"({"P":[[[[1,0,0]]],7]})", "P[1]: expected a list of actions");
  refused(R"({"P":[[7]]})", "P[0][0]: expected a list of [probability, next, reward, terminated]");
  refused(R"({"P":[[[[1,0]]]]})", "P[0][0]: found a list");
  refused(R"({"P":[[[[1,-1,0,false]]]]})", "P[0][0]: found a list");
  refused(R"({"P":[[[[2,0,0,false]]]]})", "probability 2");
  refused(R"({"P":[[[[0.5,0,0,false]]]]})", "sum to 0.5");
  refused(R"({"P":[[[[1,3,0,false]]]]})", "a step leads to state 3: expected below 1");
  refused(R"({"P":[[]]})", "no state has an action");
  refused(R"({"0":{"1":[[1,0,0,false]]}})", "action \"1\": expected 0");
  refused(R"({"1":{"0":[[1,0,0,false]]}})", "state \"1\" of P: expected 0");
  refused(R"({"format":"other","P":[]})", "\"format\" is \"other\"");
  refused(R"({"observations":[[0],[0,1]],"P":[]})", "observations[1] has 2 numbers: expected 1");
  refused(R"({"observations":[["x"]],"P":[]})", "observations[0]: found \"x\"");
  refused(R"({"observations":[[0],[1]],"P":[[[[1,0,0,false]]]]})", "2 observations for 1 states");
  refused(R"({"features":["a","b"],"P":[[[[1,0,0,false]]]]})", "2 features for observations of 1 numbers");
  refused(R"({"actions":[],"P":[[[[1,0,0,false]],[[1,0,0,false]]],[]],"initial":[1]})",
          "1 initial probabilities for 2");
  refused(R"({"initial":[2],"P":[]})", "initial[0]: found 2");
  refused(R"({"discount":3,"P":[]})", "\"discount\": expected a number from 0 to 1");
  refused(std::string(200'000, '['), "parse error");
  refused("[" + std::string(100'000, '[') + std::string(100'000, ']') + "]", "expected [probability");
}

}  // namespace
}  // namespace coppice
