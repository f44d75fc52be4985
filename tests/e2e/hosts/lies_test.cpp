// Workers that answer wrongly are found out, named and kept away, and the result is the serial one, whenever they
// began.
#include <signal.h>

#include "tests/e2e/hosts/remote_study.hpp"

namespace coppice::e2e {
namespace {

const std::vector<std::string> kPace = {"--pace", "2ms"};
const std::vector<std::string> kSettings = {"--seed", "4", "--set", "ga.generations=60"};

class Lies : public RemoteStudy {
 protected:
  Lies() { domain_ = "208"; }

  // Its first answers are true. Without a pace, so that most of the work comes to it.
  Command liar(int honest) const { return {.program = COPPICE_LIAR, .arguments = {domain_, std::to_string(honest)}}; }

  static std::vector<std::string> with(std::vector<std::string> settings, const std::vector<std::string>& more) {
    settings.insert(settings.end(), more.begin(), more.end());
    return settings;
  }
};

TEST_F(Lies, FromTheStartNeverCount) {
  const auto expected = serial_runs(kSettings);
  Process from_the_start(liar(0));
  start_worker(0, kPace);
  const auto coordinator = start_coordinator(kSettings);
  const std::string named = coordinator->await_error("answered wrongly and is quarantined");
  EXPECT_NE(named.find("pid " + std::to_string(from_the_start.pid())), std::string::npos) << named;
  const auto report = report_of(*coordinator);
  EXPECT_EQ(report["dispatch"]["quarantined"], 1);
  EXPECT_EQ(report["dispatch"]["begun_again"], 0);
  expect_same_runs("study.coppice", expected);
}

TEST_F(Lies, NeverCountWhereEverythingIsChecked) {
  const auto expected = serial_runs(kSettings);
  Process late(liar(20));
  start_worker(0, kPace);
  const auto coordinator = start_coordinator(with(kSettings, {"--cross-check", "1"}));
  coordinator->await_error("answered wrongly and is quarantined");
  const auto report = report_of(*coordinator);
  EXPECT_EQ(report["dispatch"]["quarantined"], 1);
  EXPECT_EQ(report["dispatch"]["begun_again"], 0) << "what was checked need not be done again";
  EXPECT_GT(report["dispatch"]["cross_checked"], 20);
  expect_same_runs("study.coppice", expected);
}

TEST_F(Lies, ThatCountedAreUndoneByBeginningAgain) {
  const std::vector<std::string> settings = {"--seed", "4", "--set", "ga.generations=200"};
  const auto expected = serial_runs(settings);
  Process late(liar(40));
  const auto coordinator = start_coordinator(with(settings, {"--cross-check", "0.02"}));
  coordinator->await_error("answered wrongly and is quarantined");
  coordinator->await_error("generation 1 and all after it are done again");
  start_worker(0);
  const auto report = report_of(*coordinator);
  EXPECT_EQ(report["dispatch"]["quarantined"], 1);
  EXPECT_EQ(report["dispatch"]["begun_again"], 1);
  EXPECT_EQ(report["dispatch"]["suspect_generations"], 0);
  expect_same_runs("study.coppice", expected);
}

TEST_F(Lies, AreUndoneFromWhereTheRunWasResumed) {
  const std::vector<std::string> settings = {"--seed", "4", "--set", "ga.generations=200"};
  const auto expected = serial_runs(settings);
  Process& honest = start_worker(0, kPace);
  {
    const auto first = start_coordinator(settings);
    first->await_error("evolve: 5/200");
    first->signal(SIGINT);
    EXPECT_EQ(first->wait(), kFailed);
  }
  honest.signal(SIGKILL);
  honest.wait();
  Process late(liar(40));
  const auto coordinator = start_coordinator({"--resume", "--cross-check", "0.02"});
  coordinator->await_error("answered wrongly and is quarantined");
  const std::string again = coordinator->await_error("and all after it are done again");
  EXPECT_EQ(again.find("generation 1 "), std::string::npos) << again;
  start_worker(0);
  const auto report = report_of(*coordinator);
  EXPECT_EQ(report["dispatch"]["begun_again"], 1);
  EXPECT_GE(report["dispatch"]["suspect_generations"], 5) << "who served before is not known";
  expect_same_runs("study.coppice", expected);
}

// Runs that have ended may rest on them, so it cannot go on by itself.
TEST_F(Lies, EndASweep) {
  write("sweep.toml", "seeds = 4\nepisodes = 0\n[set]\nga.generations = 150\n");
  Process late(liar(40));
  const Completed swept = coppice({"sweep", "study.coppice", "--config", "sweep.toml", "-o", "swept", "--remote",
                                   "--domain", domain_, "--cross-check", "0.02"});
  EXPECT_EQ(swept.ending, kFailed);
  EXPECT_NE(swept.error.find("begin the sweep again in another folder"), std::string::npos) << swept.error;
}

}  // namespace
}  // namespace coppice::e2e
