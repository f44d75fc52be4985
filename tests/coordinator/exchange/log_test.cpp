// Logs of transitions: what is counted, what is refused, and where bins come from.
#include <cmath>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "common/chain/random.hpp"
#include "coordinator/exchange/import_source.hpp"
#include "tests/coordinator/exchange/sources.hpp"

namespace coppice {
namespace {

using testing::SourceFiles;

// Two episodes: one ends in 3, the other is cut off in 2.
constexpr std::string_view kCsv =
    "episode,step,x,action,reward,next_x,terminated,truncated\n"
    "0,0,1,right,-1,2,0,0\n"
    "0,1,2,right,-1,1,0,0\n"
    "0,2,1,right,10,3,1,0\n"
    "1,0,1,left,-1,2,0,0\n"
    "1,1,2,right,-1,2,0,1\n";
// The same, the next line standing for where a step led; the last step of the second episode leads nowhere.
constexpr std::string_view kShort =
    "x,action,reward,terminated,truncated,episode\n"
    "1,right,-1,0,0,a\n2,right,-1,0,0,a\n1,right,10,1,0,a\n1,left,-1,0,0,b\n2,right,-1,0,1,b\n";
constexpr std::string_view kJson =
    R"({"format":"coppice-log-1","title":"way","features":[{"name":"x","unit":"m"}],"discount":0.5}
{"episode":0,"step":0,"observation":[1],"action":"right","reward":-1,"next_observation":[2],"terminated":false,"truncated":false}
{"episode":0,"step":1,"observation":{"x":2},"action":"right","reward":-1,"next_observation":[1],"terminated":false,"truncated":false}
{"episode":0,"step":2,"observation":[1],"action":"right","reward":10,"next_observation":[3],"terminated":true,"truncated":false}

{"episode":1,"step":0,"observation":[1],"action":"left","reward":-1,"next_observation":[2]}
{"episode":1,"step":1,"observation":[2],"action":"right","reward":-1,"next_observation":[2],"truncated":true}
)";

Imported imported(const std::string& path, const std::function<void(ImportSettings&)>& change = {}) {
  ImportSettings settings;
  settings.source = path;
  if (change) {
    change(settings);
  }
  auto result = import_source(settings);
  EXPECT_TRUE(result.has_value()) << path << ": " << (result ? "" : result.error().message);
  return std::move(*result);
}

TEST(Log, EveryStepIsCountedOnceAndTruncatedIsNoEnd) {
  SourceFiles files;
  for (const std::string& path : {files.write("l.csv", kCsv), files.write("l.jsonl", kJson)}) {
    SCOPED_TRACE(path);
    const Imported log = imported(path);
    const ChainParts& parts = log.chain.parts();
    EXPECT_EQ(parts.vocabulary.actions, (std::vector<std::string>{"right", "left"}));
    EXPECT_EQ(parts.features, (std::vector<std::uint8_t>{1, 2, 3}));  // in the order of first sight
    EXPECT_EQ(parts.terminals, std::vector<std::uint32_t>{2});
    EXPECT_EQ(parts.successor, (std::vector<std::uint32_t>{1, 2, 1, 0, 1, 2, 2}));
    EXPECT_EQ(parts.count, (std::vector<std::uint32_t>{1, 1, 1, 1, 1, 1, 1}));
    EXPECT_EQ(parts.reward_sum, (std::vector<double>{9, -1, -2, 0, 0, 0}));
    EXPECT_EQ(parts.visits, (std::vector<std::uint64_t>{3, 2, 0}));
    EXPECT_TRUE(parts.starts.empty());
    EXPECT_EQ(log.chain.policy(0), ActionId{0});
    EXPECT_EQ(log.report.steps, 5U);
    EXPECT_EQ(log.report.episodes, 2U);
    EXPECT_EQ(log.report.truncated, 1U);
    EXPECT_EQ(log.report.never_tried, 1U);
    EXPECT_EQ(log.report.contradictions, 1U);
  }
  EXPECT_EQ(imported(files.write("l.jsonl", kJson)).problem.discount, 0.5);
}

TEST(Log, TheNextLineStandsForWhereAStepLed) {
  SourceFiles files;
  const Imported log = imported(files.write("s.csv", kShort));
  EXPECT_EQ(log.report.steps, 4U);  // where the last one led is not said
  ASSERT_EQ(log.report.notes.size(), 2U);
  EXPECT_NE(log.report.notes[0].find("Of 1 of the steps the log does not say where they led"), std::string::npos);
  // The end of the first episode is where it was, as an end.
  EXPECT_EQ(log.chain.parts().features, (std::vector<std::uint8_t>{1, 2, 1}));
  EXPECT_EQ(log.chain.parts().terminals, std::vector<std::uint32_t>{2});
}

TEST(Log, AValueIsThatOfThePolicyThatTheLogShows) {
  SourceFiles files;
  const Imported log = imported(files.write("l.csv", kCsv), [](ImportSettings& s) { s.gamma = 0.5; });
  // right in 1: half to 2, half the end; right in 2: half to 1, half 2.
  // V1 = 4.5 + 0.5 (0.5 V2); V2 = -1 + 0.5 (0.5 V1 + 0.5 V2).
  const double v1 = (4.5 - 1.0 / 3.0) / (1.0 - 1.0 / 12.0);
  EXPECT_NEAR(*log.report.value, v1, 1e-9);
  EXPECT_EQ(*log.report.count_error, 0.0);
  const Imported solved = imported(files.write("l.csv", kCsv), [](ImportSettings& s) {
    s.gamma = 0.5;
    s.solve = true;
  });
  EXPECT_GE(*solved.report.value, v1 - 1e-9);
}

// In state 0 the action `safe` was tried ten times for 1 each, `lucky` once for 100; state 1 knows `safe` only.
TEST(Log, SolvingSaysWhatItBelievesAndLeavesOutWhatWasTriedTooSeldom) {
  std::string text = "x,action,reward,next_x\n0,lucky,100,1\n1,safe,0,0\n";
  for (int i = 0; i < 10; ++i) {
    text += "0,safe,1,0\n";
  }
  SourceFiles files;
  const std::string path = files.write("lucky.csv", text);
  const auto solved = [&](std::uint64_t min_visits) {
    return imported(path, [&](ImportSettings& s) {
      s.solve = true;
      s.gamma = 0.5;
      s.min_visits = min_visits;
    });
  };
  const Imported credulous = solved(1);
  EXPECT_EQ(credulous.chain.vocabulary().actions[index_of(credulous.chain.policy(0))], "lucky");
  EXPECT_EQ(credulous.report.solved_on_one_try, 2U);
  EXPECT_EQ(credulous.report.distrusted, 0U);
  ASSERT_EQ(credulous.report.notes.size(), 1U);
  EXPECT_NE(credulous.report.notes[0].find("in 2 of 2 states the action that it chose was tried only once"),
            std::string::npos)
      << credulous.report.notes[0];

  const Imported careful = solved(5);
  EXPECT_EQ(careful.chain.vocabulary().actions[index_of(careful.chain.policy(0))], "safe");
  EXPECT_EQ(careful.chain.vocabulary().actions[index_of(careful.chain.policy(1))], "safe") << "it has no other";
  EXPECT_EQ(careful.report.solved_on_one_try, 1U);
  EXPECT_EQ(careful.report.distrusted, 1U);
  EXPECT_NEAR(careful.chain.parts().q[careful.chain.row(0, careful.chain.policy(0))], 2.0, 1e-9);
  EXPECT_LE(careful.chain.parts().q[0], 2.0) << "what must not be taken is worth no more than what may";

  ImportSettings without;
  without.source = path;
  without.min_visits = 5;
  EXPECT_NE(import_source(without).error().message.find("--min-visits"), std::string::npos);
}

TEST(Log, EndsMayStartAgainAndCollisionsAreCountedByRewardOrTest) {
  SourceFiles files;
  const Imported again = imported(files.write("l.csv", kCsv), [](ImportSettings& s) {
    s.problem.terminal = WhenTerminal::again;
    s.problem.collision_reward = -1.0;
    s.problem.no_action = "left";
  });
  EXPECT_EQ(again.chain.successors(4)[0], 0U);
  EXPECT_EQ(again.chain.parts().collisions, (std::vector<std::uint32_t>{1, 1, 2, 0, 0, 0}));
  EXPECT_EQ(again.chain.parts().no_action, (NoAction{NoAction::Kind::named, ActionId{1}}));
  const Imported tested =
      imported(files.write("l.csv", kCsv), [](ImportSettings& s) { s.problem.collisions.when = "x>=2"; });
  EXPECT_EQ(tested.chain.parts().collisions, (std::vector<std::uint32_t>{2, 1, 1, 0, 0, 0}));
}

TEST(Log, WhatIsWrongIsNamedWithItsLine) {
  SourceFiles files;
  const auto refused = [&files](std::string_view from, std::string_view to, const std::string& message) {
    std::string text(kCsv);
    const std::size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos);
    ImportSettings settings;
    settings.source = files.write("bad.csv", text.replace(at, from.size(), to));
    settings.format = SourceFormat::csv_log;
    const auto log = import_source(settings);
    ASSERT_FALSE(log.has_value()) << message;
    EXPECT_NE(log.error().message.find("bad.csv"), std::string::npos) << log.error().message;
    EXPECT_NE(log.error().message.find(message), std::string::npos) << log.error().message;
  };
  refused("0,1,2,right", "0,2,2,right", "line 3: episode 0: step 2 comes after step 0: expected 1");
  refused("0,1,2,right", "0,1,7,right", "line 3: episode 0 has a gap");
  refused("-1,2,0,0", "-1,2,1,0", "line 3: episode 0 goes on after its end");
  refused("0,1,2,right,-1,1", "0,1,2,right,x,1", "line 3: column 5: found 'x': expected a finite number");
  refused("0,1,2,right,-1,1", "0,1,inf,right,-1,1", "column 3: found 'inf': expected a finite number");
  refused("0,1,2,right,-1,1,0,0", "0,1,2,right,-1,1,0", "line 3: 7 fields: expected 8");
  refused("0,1,2,right,-1,1,0,0", "0,1,2,right,-1,1,maybe,0", "found 'maybe': expected true or false");
  refused(",action,", ",deed,", "no column 'action'");
  refused(",next_x", ",next_y", "expected all or none, and no others");
  refused(",x,", ",x,x,", "two columns 'x'");
  EXPECT_EQ(import_source({.source = files.write("e.csv", "x,action,reward\n"), .format = SourceFormat::csv_log})
                    .error()
                    .message.find("no steps") == std::string::npos,
            false);
}

TEST(Log, ContinuousFeaturesAreCutWhereThePolicyChanges) {
  SourceFiles files;
  Xoshiro256 random(11);
  std::string text = "angle,speed,action,reward,next_angle,next_speed\n";
  for (int i = 0; i < 4000; ++i) {
    const double angle = static_cast<double>(random.below(2'000'001)) / 1e6 - 1.0;
    const double speed = static_cast<double>(random.below(2'000'001)) / 1e6 - 1.0;
    text += fmt::format("{},{},{},1,{},{}\n", angle, speed, angle <= 0.0419 ? 0 : 1, angle, speed);
  }
  const std::string path = files.write("pole.csv", text);
  const Imported log = imported(path);
  const Feature& angle = log.chain.vocabulary().features[0];
  ASSERT_EQ(angle.scale, Scale::bins);
  ASSERT_EQ(angle.numbers.size(), 1U);
  EXPECT_NEAR(angle.numbers[0], 0.0419, 0.005);
  EXPECT_LT(*log.report.bin_disagreement, 0.01);
  const Imported given = imported(path, [](ImportSettings& s) {
    s.problem.features["angle"].binning = Binning{.kind = Binning::Kind::edges, .edges = {0.0419, -0.5}, .bins = 0};
    s.problem.features["speed"].binning = Binning{.kind = Binning::Kind::quantiles, .edges = {}, .bins = 4};
  });
  EXPECT_EQ(given.chain.vocabulary().features[0].numbers, (std::vector<double>{-0.5, 0.0419}));
  EXPECT_EQ(given.chain.vocabulary().features[1].numbers.size(), 3U);
  EXPECT_EQ(given.chain.states(), 12U);
  EXPECT_EQ(*given.report.bin_disagreement, 0.0);
}

TEST(Log, AnActionOrReadingsThatComeLateAreFoundAllTheSame) {
  SourceFiles files;
  std::string text = "x,y,action,reward,next_x,next_y\n";
  for (int i = 0; i < 100'500; ++i) {
    text += fmt::format("{},{},{},0,0,0\n", i % 3, i < 100'200 ? i % 2 : i, i == 100'400 ? "late" : "early");
  }
  const Imported log = imported(files.write("late.csv", text));
  EXPECT_EQ(log.chain.vocabulary().actions, (std::vector<std::string>{"early", "late"}));
  EXPECT_EQ(log.chain.vocabulary().features[1].scale, Scale::bins);
  EXPECT_EQ(log.report.steps, 100'500U);
}

}  // namespace
}  // namespace coppice
