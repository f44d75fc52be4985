// What is told of formats, names, wishes and look-alikes, whichever the format.
#include <cmath>
#include <gtest/gtest.h>

#include "common/tree/text.hpp"
#include "coordinator/exchange/import_source.hpp"
#include "tests/coordinator/exchange/sources.hpp"

namespace coppice {
namespace {

using testing::SourceFiles;

TEST(Format, IsToldFromTheContent) {
  SourceFiles files;
  const auto format = [&files](std::string_view content) { return format_of(files.write("f", content)); };
  EXPECT_EQ(*format("// by storm\n@type: MDP\n"), SourceFormat::drn);
  EXPECT_EQ(*format("3 4 5\n0 0 1 1\n"), SourceFormat::prism);
  EXPECT_EQ(*format("\xEF\xBB\xBFx,action,reward\n"), SourceFormat::csv_log);
  EXPECT_EQ(*format(R"({"format":"coppice-log-1"})"), SourceFormat::json_log);
  EXPECT_EQ(*format("{\"observation\":[1],\"action\":1,\"reward\":0}\n"), SourceFormat::json_log);
  EXPECT_EQ(*format("{\"actions\":[1],\n\"P\":[]}"), SourceFormat::tables);
  EXPECT_EQ(*format("[[[[1,0,0,false]]]]"), SourceFormat::tables);
  for (const std::string_view content : {"", "hello", "SQLite format 3", "1,2,3\n"}) {
    EXPECT_NE(format(content).error().message.find("line 1: no format is known that begins so"), std::string::npos);
  }
  EXPECT_NE(format_of("/").error().message.find("is a folder"), std::string::npos);
  EXPECT_NE(format_of("/no/such").error().message.find("/no/such: cannot be opened"), std::string::npos);
  EXPECT_FALSE(value_named<SourceFormat>("format", "xml").has_value());
}

constexpr std::string_view kTwins = R"(@type: MDP
@parameters

@reward_models
r
@nr_states
4
@nr_choices
6
@model
state 0 [0] init
//[x=0 & far=-1000]
	action (a b) [0]
		1 : 0.5
		2 : 0.5
state 1 [0]
//[x=1 & far=5]
	action (a b) [4]
		3 : 1
	action 2 [0]
		3 : 1
state 2 [0]
//[x=1 & far=5]
	action (a b) [0]
		3 : 1
	action 2 [2]
		3 : 1
state 3 [0]
//[x=2 & far=5]
	action 2 [0]
		3 : 1
)";

ImportSettings twins(SourceFiles& files) {
  ImportSettings settings;
  settings.source = files.write("twins.drn", kTwins);
  settings.solve = true;
  settings.gamma = 0.5;
  return settings;
}

TEST(Import, NamesBecomeLegalAndKeepTheirOldOnesAsLabels) {
  SourceFiles files;
  const auto imported = import_source(twins(files));
  ASSERT_TRUE(imported.has_value()) << imported.error().message;
  EXPECT_EQ(imported->chain.vocabulary().actions, (std::vector<std::string>{"a_b", "a2"}));
  EXPECT_EQ(imported->problem.action_labels, (std::vector<std::string>{"(a b)", "2"}));
  const Feature& far = imported->chain.vocabulary().features[1];
  EXPECT_EQ(far.scale, Scale::numbers);
  EXPECT_TRUE(parse_tree("(sequence far=-1000 x<=1 a_b)", imported->chain.vocabulary()).has_value());
  EXPECT_EQ(imported->problem.discount, 0.5);
  EXPECT_EQ(imported->report.format, "drn");
}

TEST(Import, LookAlikesAreKeptApartOrMergedWithWhatIsLost) {
  SourceFiles files;
  ImportSettings settings = twins(files);
  const auto apart = import_source(settings);
  ASSERT_TRUE(apart.has_value()) << apart.error().message;
  EXPECT_EQ(apart->chain.states(), 4U);
  EXPECT_EQ(apart->report.look_alikes, 1U);
  EXPECT_TRUE(apart->chain.parts().look_alikes);
  EXPECT_NEAR(*apart->report.value, 0.5 * (0.5 * 4 + 0.5 * 2), 1e-9);
  settings.problem.look_alikes = LookAlikes::merge;
  const auto merged = import_source(settings);
  ASSERT_TRUE(merged.has_value()) << merged.error().message;
  EXPECT_EQ(merged->chain.states(), 3U);
  EXPECT_EQ(merged->report.merged_states, 1U);
  EXPECT_NEAR(*merged->report.value, 1.5, 1e-9);
  EXPECT_NEAR(*merged->report.merged_value, 1.0, 1e-9) << "one action for both: 4 or 0, each half of the time";
  EXPECT_NEAR(merged->chain.mean_reward(2), 2.0, 1e-9);
  EXPECT_LT(std::abs(*merged->report.count_error), 1e-9);
}

TEST(Import, WishesOfTheProblemFileAreHeeded) {
  SourceFiles files;
  ImportSettings settings = twins(files);
  ProblemFile& file = settings.problem;
  file.features["x"] = {.name = "place", .label = "where", .unit = "m", .values = {{0, "here"}, {9, "nowhere"}}};
  file.features["far"].binning = Binning{.kind = Binning::Kind::edges, .edges = {0.25}, .bins = 0};
  file.actions["(a b)"] = {.name = "go", .label = "go on"};
  file.no_action = "2";
  file.collisions.when = "x=2";
  file.initial.shares = {{1, 3.0}, {2, 1.0}};
  file.terminal = WhenTerminal::again;
  const auto imported = import_source(settings);
  ASSERT_TRUE(imported.has_value()) << imported.error().message;
  const Chain& chain = imported->chain;
  EXPECT_EQ(chain.states(), 3U) << "state 0 is not reached any more";
  EXPECT_EQ(chain.vocabulary().features[0].name, "place");
  EXPECT_EQ(imported->problem.features[0].values.size(), 0U) << "nothing reads 0 any more";
  EXPECT_EQ(chain.vocabulary().features[1].numbers, std::vector<double>{0.25});
  EXPECT_EQ(chain.vocabulary().actions[0], "go");
  EXPECT_EQ(chain.parts().no_action, (NoAction{NoAction::Kind::named, ActionId{1}}));
  EXPECT_EQ(chain.starts().size(), 2U);
  EXPECT_EQ(chain.starts()[0].count, 3U);
  EXPECT_EQ(chain.collision_share(0), 1.0);
  ASSERT_EQ(chain.parts().terminals, std::vector<std::uint32_t>{2});
  EXPECT_EQ(chain.successors(4).size(), 2U) << "the end leads to the starts";
}

TEST(Import, WishesThatFitNothingAreRefused) {
  SourceFiles files;
  const auto refused = [&files](const std::function<void(ImportSettings&)>& change, const std::string& message) {
    ImportSettings settings = twins(files);
    change(settings);
    const auto imported = import_source(settings);
    ASSERT_FALSE(imported.has_value()) << message;
    EXPECT_EQ(imported.error().kind, ErrorKind::bad_input);
    EXPECT_NE(imported.error().message.find(message), std::string::npos) << imported.error().message;
  };
  refused([](ImportSettings& s) { s.problem.features["y"]; },
          "features.y: no such feature in the source: expected one");
  refused([](ImportSettings& s) { s.problem.actions["b"]; }, "actions.b: no such action in the source");
  refused([](ImportSettings& s) { s.problem.no_action = "b"; }, "no_action is 'b': expected hold, worst or an action");
  refused([](ImportSettings& s) { s.problem.without_actions = {"b"}; }, "no action 'b' to leave out");
  refused([](ImportSettings& s) { s.problem.without_actions = {"2", "(a b)"}; }, "no action is left");
  refused([](ImportSettings& s) { s.problem.terminals.label = "goal"; }, "terminals.label: no label 'goal'");
  refused([](ImportSettings& s) { s.problem.terminals.when = "x=9"; }, "terminals: no state fits");
  refused(
      [](ImportSettings& s) {
        s.problem.initial.shares = {{9, 1}};
      },
      "initial.shares: state 9 is not in the source");
  refused([](ImportSettings& s) { s.problem.collisions.when = "z=9"; }, "collisions.when: column 1: found 'z'");
  refused([](ImportSettings& s) { s.gamma.reset(); }, "--solve needs --gamma");
  refused([](ImportSettings& s) { s.solve = false; }, "a model without a policy: expected --solve");
  refused([](ImportSettings& s) { s.q = "q.npy"; }, "--solve makes Q-values and policy");
  refused([](ImportSettings& s) { s.gamma = 1.0; }, "--gamma is 1: expected 0 to 0.999999");
  refused(
      [](ImportSettings& s) {
        s.problem.features["far"].admits_equal = true;
        s.problem.features["far"].binning = Binning{.kind = Binning::Kind::quantiles, .edges = {}, .bins = 2};
      },
      "feature 'far' has bins: expected the operator <= only");
}

TEST(Import, AFeatureWithTooManyReadingsIsCutFinely) {
  SourceFiles files;
  std::string text = "@type: DTMC\n@parameters\n\n@reward_models\n\n@nr_states\n1000\n@nr_choices\n1000\n@model\n";
  for (int state = 0; state < 1000; ++state) {
    text += "state " + std::to_string(state) + (state == 0 ? " init" : "") + "\n\taction go\n\t\t" +
            std::to_string((state + 1) % 1000) + " : 1\n";
  }
  ImportSettings settings;
  settings.source = files.write("long.drn", text);
  settings.solve = true;
  settings.gamma = 0.9;
  const auto imported = import_source(settings);
  ASSERT_TRUE(imported.has_value()) << imported.error().message;
  const Feature& state = imported->chain.vocabulary().features[0];
  EXPECT_EQ(state.scale, Scale::bins);
  EXPECT_GT(state.values.size(), 100U);
  EXPECT_EQ(imported->chain.states(), 1000U);
  EXPECT_GT(imported->report.look_alikes, 700U);
}

}  // namespace
}  // namespace coppice
