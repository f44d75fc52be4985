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
  EXPECT_EQ(report["dispatch"]["rollbacks"], 0);
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
  EXPECT_EQ(report["dispatch"]["rollbacks"], 0) << "what was checked need not be done again";
  EXPECT_GT(report["dispatch"]["cross_checked"], 20);
  expect_same_runs("study.coppice", expected);
}

TEST_F(Lies, ThatCountedAreUndoneByBeginningAgain) {
  const std::vector<std::string> settings = {"--seed", "4", "--set", "ga.generations=200"};
  const auto expected = serial_runs(settings);
  Process late(liar(40));
  const auto coordinator = start_coordinator(with(settings, {"--cross-check", "0.02"}));
  coordinator->await_error("answered wrongly and is quarantined");
  coordinator->await_error("rolling back: generation 1 and all after it");
  start_worker(0);
  const auto report = report_of(*coordinator);
  EXPECT_EQ(report["dispatch"]["quarantined"], 1);
  EXPECT_EQ(report["dispatch"]["rollbacks"], 1);
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
    EXPECT_EQ(first->wait(), kInterrupted);
  }
  honest.signal(SIGKILL);
  honest.wait();
  Process late(liar(40));
  const auto coordinator = start_coordinator({"--resume", "--cross-check", "0.02"});
  coordinator->await_error("answered wrongly and is quarantined");
  const std::string again = coordinator->await_error("and all after it were bred from");
  EXPECT_EQ(again.find("generation 1 "), std::string::npos) << again;
  start_worker(0);
  const auto report = report_of(*coordinator);
  EXPECT_EQ(report["dispatch"]["rollbacks"], 1);
  EXPECT_GE(report["dispatch"]["suspect_generations"], 5) << "who served before is not known";
  expect_same_runs("study.coppice", expected);
}

// One of a worker's first eight answers is checked for certain, here an epoch that is a whole run: which one is chance,
// so what counted before may have to be revoked or not. Either way the tables are the serial ones.
TEST_F(Lies, OfASweepAreInNoneOfItsTables) {
  write("sweep.toml", "seeds = 12\nepisodes = 0\nconfig = \"thesis.toml\"\n[set]\nga.generations = 30\n");
  write("thesis.toml", "[ga]\npopulation = 60\n");
  ASSERT_EQ(coppice({"sweep", "study.coppice", "--config", "sweep.toml", "-o", "serial", "--serial"}).ending, kDone);
  Process late(liar(0));
  Process swept(command({"sweep", "study.coppice", "--config", "sweep.toml", "-o", "swept", "--remote", "--domain",
                         domain_, "--cross-check", "0.02", "--at-once", "1"}));
  swept.await_error("answered wrongly and is quarantined");
  start_worker(0);
  EXPECT_EQ(swept.wait(), kDone) << swept.rest_of_error();
  const auto trees = [this](const std::string& folder) {
    std::vector<std::string> found;
    for (const std::string& row : lines_of(read(folder + "/runs.csv"))) {
      found.push_back(row.substr(row.find('(') == std::string::npos ? 0 : row.find('(')));
    }
    return found;
  };
  EXPECT_EQ(trees("swept"), trees("serial"));
  EXPECT_EQ(trees("swept").size(), 13U);
}

}  // namespace
}  // namespace coppice::e2e
