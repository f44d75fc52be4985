#include <fstream>
#include <signal.h>

#include "tests/e2e/cli/command_line.hpp"

namespace coppice::e2e {
namespace {

using Learn = CommandLine;

TEST_F(Learn, MakesAStudyAndReportsWhatItLearned) {
  const auto report = coppice_json({"learn", "-o", "a.coppice", "--episodes", "300", "--seed", "7", "--json"});
  EXPECT_EQ(report["settings"]["episodes"], 300);
  EXPECT_EQ(report["settings"]["seed"], 7);
  EXPECT_EQ(report["outcome"]["steps"], 300 * 150);
  EXPECT_EQ(files(), std::vector<std::string>{"a.coppice"});
  const auto info = coppice_json({"info", "a.coppice", "--json"});
  EXPECT_EQ(info["states"], report["outcome"]["states"]);
  EXPECT_EQ(info["learning"]["settings"], report["settings"]);
}

TEST_F(Learn, TheSameSeedGivesTheSameChainAndAnotherSeedAnother) {
  for (const auto& [file, seed] : {std::pair{"a.coppice", "7"}, {"b.coppice", "7"}, {"c.coppice", "8"}}) {
    ASSERT_EQ(coppice({"learn", "-o", file, "--episodes", "200", "--seed", seed}).ending, kDone);
  }
  const auto chain = [&](const char* file) { return coppice_json({"info", file, "--json"})["chain"]; };
  EXPECT_EQ(chain("a.coppice"), chain("b.coppice"));
  EXPECT_NE(chain("a.coppice"), chain("c.coppice"));
}

TEST_F(Learn, TheWindyGridHasItsOwnFeaturesAndActions) {
  ASSERT_EQ(
      coppice({"learn", "-o", "w.coppice", "--world", "windy", "--algorithm", "sarsa", "--episodes", "200"}).ending,
      kDone);
  const auto info = coppice_json({"info", "w.coppice", "--json"});
  EXPECT_EQ(info["world"], "windy");
  EXPECT_EQ(info["actions"].size(), 4U);
  EXPECT_FALSE(info.contains("states_with_wall_ahead"));
}

TEST_F(Learn, AnExistingStudyIsNotOverwritten) {
  learn_study();
  const std::string before = read("study.coppice");
  expect_wrong_use({"learn", "-o", "study.coppice", "--episodes", "10"}, {"study.coppice", "exists already"});
  EXPECT_EQ(read("study.coppice"), before);
}

TEST_F(Learn, WrongFlagsAndRoomsLeaveNoFile) {
  write("bad.room", "####\n#.x#\n####\n");
  expect_wrong_use({"learn", "-o", "a.coppice", "--alpha", "7"}, {"--alpha", "7"});
  expect_wrong_use({"learn", "-o", "a.coppice", "--episodes", "-5"}, {"--episodes", "-5"});
  expect_wrong_use({"learn", "-o", "a.coppice", "--seed", "99999999999999999999"}, {"--seed", "99999999999999999999"});
  expect_wrong_use({"learn", "-o", "a.coppice", "--decay", "never"}, {"--decay", "never", "thesis"});
  expect_wrong_use({"learn", "-o", "a.coppice", "--algorithm", "dqn"}, {"--algorithm", "dqn", "sarsa"});
  expect_wrong_use({"learn", "-o", "a.coppice", "--world", "bad.room"}, {"bad.room", "line 2"});
  expect_wrong_use({"learn", "-o", "nowhere/a.coppice"}, {"nowhere"});
  EXPECT_EQ(files(), std::vector<std::string>{"bad.room"});
}

TEST_F(Learn, WhatIsInterruptedIsKeptAndResumed) {
  const auto interrupt = [&](const std::vector<std::string>& arguments) {
    Process process(command(arguments));
    process.await_blocked(SIGINT);
    process.signal(SIGINT);
    EXPECT_EQ(process.wait(), kInterrupted) << process.rest_of_error();
    EXPECT_EQ(files(), std::vector<std::string>{"a.coppice.learning"});
    return read("a.coppice.learning");
  };
  const std::string first = interrupt({"learn", "-o", "a.coppice", "--episodes", "28000000"});
  expect_wrong_use({"learn", "-o", "a.coppice", "--episodes", "10"}, {"a.coppice.learning", "--resume"});
  expect_wrong_use({"learn", "-o", "a.coppice", "--resume", "--gamma", "0.5"}, {"--resume", "--gamma"});
  EXPECT_EQ(read("a.coppice.learning"), first);
  EXPECT_NE(interrupt({"learn", "-o", "a.coppice", "--resume"}), first);
  std::string damaged = first;
  damaged[damaged.size() / 2] ^= 1;
  write("a.coppice.learning", damaged);
  expect_wrong_use({"learn", "-o", "a.coppice", "--resume"}, {"a.coppice.learning", "damaged"});
  expect_wrong_use({"learn", "-o", "b.coppice", "--resume"}, {"b.coppice.learning", "interrupted"});
}

TEST_F(Learn, ABatteryRoomIsLearnedAndEvolvedIn) {
  ASSERT_EQ(coppice({"learn", "-o", "b.coppice", "--world", "battery", "--episodes", "2000"}).ending, kDone);
  const auto info = coppice_json({"info", "b.coppice", "--json"});
  EXPECT_EQ(info["world"], "battery");
  EXPECT_EQ(info["actions"].back(), "charge");
  const Completed evolved =
      coppice({"evolve", "b.coppice", "--serial", "--set", "ga.generations=3", "--set", "ga.population=20"});
  ASSERT_EQ(evolved.ending, kDone) << evolved.error;
}

TEST_F(Learn, SynthStartsAStudyThatCanBeEvaluatedButNotScored) {
  const auto made = coppice_json({"synth", "-o", "s.coppice", "--states", "70000", "--branching", "3", "--json"});
  EXPECT_EQ(made["transitions"], 70000 * 3 * 3);
  const Completed again = coppice({"synth", "-o", "s.coppice", "--states", "10", "--branching", "2"});
  EXPECT_EQ(again.ending, kBadInput);
  const Completed scored = coppice({"score", "s.coppice", "--tree", "a0"});
  EXPECT_EQ(scored.ending, kBadInput);
  EXPECT_NE(scored.error.find("no world"), std::string::npos) << scored.error;
  // Beyond the states that tables are made for: walked lazily, serially and by workers alike.
  write("trees", "a0\n(selector (sequence f0=1 f3<=1 a0) (sequence f1=2 a1) a2)\n");
  const Completed serial = coppice({"evaluate", "s.coppice", "--trees", "trees", "--serial"});
  const Completed workers = coppice({"evaluate", "s.coppice", "--trees", "trees", "--workers", "2"});
  EXPECT_EQ(serial.ending, kDone) << serial.error;
  EXPECT_EQ(serial.output, workers.output) << workers.error;
}

}  // namespace
}  // namespace coppice::e2e
