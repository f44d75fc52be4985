#include "coordinator/exchange/drn.hpp"

#include <cstdlib>
#include <filesystem>
#include <gtest/gtest.h>

#include "coordinator/exchange/import_source.hpp"
#include "tests/coordinator/exchange/sources.hpp"

namespace coppice {
namespace {

using testing::SourceFiles;

constexpr std::string_view kSmall = R"(// Exported by storm
@type: MDP
@value_type: double
@parameters

@reward_models
gain cost
@nr_states
3
@nr_choices
4
@model
state 0 [1, 0] init
//[x=0	& !done	& level=-3]
	action (go) [2, 0.5]
		1 : 1/2
		1 : 0.25
		0 : 0.25
		2 : 0
	action stay [0, 0]
		0 : 1
state 1 [0, 4] there
//[x=300	& done	& level=7]
	action (go) [0, 0]
		2 : 1
state 2
	action __NOLABEL__
		2 : 1
)";

std::string with(std::string_view from, std::string_view to) {
  std::string text(kSmall);
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(Drn, IsReadAsStormMeansIt) {
  SourceFiles files;
  const auto model = read_drn(files.write("small.drn", kSmall), "");
  ASSERT_TRUE(model.has_value()) << model.error().message;
  EXPECT_EQ(model->feature_names, (std::vector<std::string>{"x", "done", "level"}));
  EXPECT_EQ(model->action_names, (std::vector<std::string>{"(go)", "stay", "choice0"}));
  // The sink reads what the state before it does.
  EXPECT_EQ(model->readings, (std::vector<double>{0, 0, -3, 300, 1, 7, 300, 1, 7}));
  EXPECT_EQ(model->successor, (std::vector<std::uint32_t>{0, 1, 0, 2, 2}));
  EXPECT_EQ(model->probability, (std::vector<double>{0.25, 0.75, 1, 1, 1}));
  EXPECT_EQ(model->row_begin, (std::vector<std::uint64_t>{0, 2, 3, 3, 4, 4, 4, 4, 4, 5}));
  // Of the state and the choice together, gain less cost.
  EXPECT_EQ(model->reward, (std::vector<double>{2.5, 1, 0, -4, 0, 0, 0, 0, 0}));
  EXPECT_EQ(model->terminals, std::vector<std::uint32_t>{2});
  ASSERT_EQ(model->starts.size(), 1U);
  EXPECT_EQ(model->starts[0].state, 0U);
  EXPECT_EQ(model->labels.at("there"), std::vector<std::uint32_t>{1});
  EXPECT_EQ(read_drn(files.write("again.drn", kSmall), "cost")->reward[0], 0.5);
  EXPECT_EQ(read_drn(files.write("both.drn", kSmall), "cost + gain")->reward[0], 3.5);
}

TEST(Drn, WhatIsWrongIsNamedWithItsLine) {
  SourceFiles files;
  const auto refused = [&files](const std::string& text, const std::string& message) {
    const auto model = read_drn(files.write("bad.drn", text), "");
    ASSERT_FALSE(model.has_value()) << message;
    EXPECT_EQ(model.error().kind, ErrorKind::bad_input);
    EXPECT_NE(model.error().message.find("bad.drn"), std::string::npos);
    EXPECT_NE(model.error().message.find(message), std::string::npos) << model.error().message;
  };
  refused(with("@type: MDP", "@type: CTMC"), "line 2: a model of type 'CTMC': expected MDP or DTMC");
  refused(with("double", "double-interval"), "line 3: values of type 'double-interval'");
  refused(with("@parameters\n", "@parameters\np"), "parameters 'p': expected a model without");
  refused(with("@nr_states\n3", "@nr_states\n99999999999"), "states: expected 1 to");
  refused(with("@nr_states\n3", "@nr_states\n4"), "the end after 3 states: expected 4");
  refused(with("@nr_states\n3", "@nr_states\n2"), "expected a state below 2");
  refused(with("state 1", "state 2"), "line 22: state '2': expected state 1");
  refused(with("1 : 1/2", "1 : 1/0"), "expected a state below 3, ':' and a probability");
  refused(with("1 : 1/2", "7 : 1/2"), "found '7 : 1/2'");
  refused(with("1 : 1/2", "1 : 0.4"), "sum to 0.9");
  refused(with("[2, 0.5]", "[2]"), "expected 2 numbers, one for each reward model");
  refused(with("[2, 0.5]", "[2, inf]"), "expected 2 numbers");
  refused(with("[2, 0.5]", "[2, 0.5"), "expected ']'");
  refused(with("level=7", "depth=7"), "feature 'depth' was not in the valuations before");
  refused(with("action stay", "action (go)"), "state 0 has action 0 twice");
  refused(with(" init", ""), "no state where episodes start");
  refused(with("@model\n", ""), "found 'state 0");
  refused("@type: MDP\n", "expected @model");
  EXPECT_NE(read_drn(files.write("x.drn", kSmall), "speed").error().message.find("no reward 'speed' in the model"),
            std::string::npos);
  EXPECT_NE(read_drn(files.write("y.drn", with("gain cost", "up down")), "")
                .error()
                .message.find("several rewards (up, down): choose with --reward"),
            std::string::npos);
  EXPECT_NE(read_drn("/no/such.drn", "").error().message.find("/no/such.drn: cannot be opened"), std::string::npos);
}

TEST(Drn, EveryCutOfAFileIsRefusedOrAModel) {
  SourceFiles files;
  for (std::size_t size = 0; size < kSmall.size(); size += 3) {
    const auto model = read_drn(files.write("cut.drn", kSmall.substr(0, size)), "");
    EXPECT_TRUE(model.has_value() || !model.error().message.empty());
  }
}

double solved(const std::string& path, std::vector<std::string> without = {}) {
  ImportSettings settings;
  settings.source = path;
  settings.solve = true;
  settings.gamma = 0.99;
  settings.problem.without_actions = std::move(without);
  const auto imported = import_source(settings);
  EXPECT_TRUE(imported.has_value()) << path << ": " << (imported ? "" : imported.error().message);
  EXPECT_LT(std::abs(imported->report.count_error.value()), 1e-5);
  return imported->report.value.value();
}

// Optima as dtPAYNT's authors published them (CAV 2025, original-logs/final-merge.csv), which OMDT's agree with.
TEST(Drn, LakesReachTheirPublishedOptima) {
  SourceFiles files;
  EXPECT_NEAR(solved(files.write("lake4.drn", testing::lake_drn(testing::kLake4))), 0.54203, 5e-6);
  EXPECT_NEAR(solved(files.write("lake8.drn", testing::lake_drn(testing::kLake8))), 0.41464, 5e-6);
}

// The published models themselves may not be copied into the project: where somebody has them, COPPICE_PUBLISHED_MODELS
// names their folder.
TEST(Drn, PublishedModelsReachTheirOptima) {
  const char* folder = std::getenv("COPPICE_PUBLISHED_MODELS");
  if (folder == nullptr) {
    GTEST_SKIP() << "COPPICE_PUBLISHED_MODELS does not name a folder with the models";
  }
  struct Published {
    const char* name;
    double optimum;
    double printed;  // half of the last digit
  };
  for (const Published& published : {Published{"3d_navigation", 0.35185, 5e-6},
                                     {"blackjack", -2.17321, 5e-6},
                                     {"frozenlake_4x4", 0.54203, 5e-6},
                                     {"frozenlake_8x8", 0.41464, 5e-6},
                                     {"frozenlake_12x12", 0.34872, 5e-6},
                                     {"traffic_intersection", 2.1246, 5e-5},
                                     {"system_administrator_tree", 557.72, 5e-3},
                                     {"maze-steps", -17.1595, 5e-5},
                                     {"maze-7", 5.1796, 5e-5},
                                     {"resource-gathering-5", -47.7105, 5e-5}}) {
    const std::filesystem::path path = std::filesystem::path(folder) / (std::string(published.name) + ".drn");
    EXPECT_NEAR(solved(path.string(), {"__random__"}), published.optimum, published.printed) << published.name;
  }
}

}  // namespace
}  // namespace coppice
