// Standing workers: listed while they wait and while they work, and at hand for one coordinator after another.
#include <signal.h>

#include "tests/e2e/hosts/remote_study.hpp"

namespace coppice::e2e {
namespace {

const std::vector<std::string> kShort = {"--seed", "4", "--set", "ga.generations=30"};
const std::vector<std::string> kEndless = {"--seed", "4", "--set", "ga.generations=100000"};

class StandingWorkers : public RemoteStudy {
 protected:
  StandingWorkers() { domain_ = "202"; }

  nlohmann::json list() const { return coppice_json({"workers", "--domain", domain_, "--json"}); }
  // Again until so many are there.
  nlohmann::json list_of(std::size_t workers) const {
    nlohmann::json listed;
    for (int i = 0; i < kMostLists && listed["workers"].size() != workers; ++i) {
      listed = list();
    }
    return listed;
  }

  static constexpr int kMostLists = 30;
};

TEST_F(StandingWorkers, AreListedWhileTheyWaitAndWhileTheyWork) {
  Process& first = start_worker(0, {"--pace", "2ms", "--threads", "2"});
  start_worker(0, {"--pace", "2ms"});
  const auto waiting = list_of(2);
  ASSERT_EQ(waiting["workers"].size(), 2U) << waiting.dump();
  EXPECT_TRUE(waiting["coordinator"].is_null());
  EXPECT_EQ(waiting["workers"][0]["doing"], "waiting for a coordinator");

  const auto coordinator = start_coordinator(kEndless);
  coordinator->await_error("2 workers");
  const auto working = list();
  EXPECT_EQ(working["coordinator"]["pid"], coordinator->pid());
  ASSERT_EQ(working["workers"].size(), 2U) << working.dump();
  for (const auto& worker : working["workers"]) {
    const bool is_first = worker["pid"] == first.pid();
    EXPECT_EQ(worker["threads"], is_first ? 2 : 1);
    EXPECT_GE(worker["cores"], 1);
    EXPECT_GE(worker["protocol"], 1);
    EXPECT_LT(worker["seen_seconds"], 10.0);
    EXPECT_NE(worker["doing"], "waiting for a coordinator");
  }
  coordinator->signal(SIGINT);
  EXPECT_EQ(coordinator->wait(), kInterrupted);
}

TEST_F(StandingWorkers, ServeOneCoordinatorAfterAnotherAndKeepTheChain) {
  const auto expected = serial_runs(kShort);
  const std::string learned = read("study.coppice");
  Process& worker = start_worker(0);
  for (int i = 0; i < 3; ++i) {
    write("study.coppice", learned);
    report_of(*start_coordinator(kShort));
    expect_same_runs("study.coppice", expected);
  }
  worker.signal(SIGTERM);
  EXPECT_EQ(worker.wait(), kDone);
  const std::string said = worker.rest_of_error();
  const auto times = [&](const std::string& part) {
    std::size_t count = 0;
    for (std::size_t at = said.find(part); at != std::string::npos; at = said.find(part, at + 1)) {
      ++count;
    }
    return count;
  };
  EXPECT_EQ(times("serving the coordinator"), 3U) << said;
  EXPECT_EQ(times("holds chain"), 1U) << said;
}

TEST_F(StandingWorkers, WaitForACoordinatorThatCannotBeReachedYet) {
  Process worker({.program = COPPICE_WORKER_PROGRAM, .arguments = {"--coordinator", "no-such-host.invalid"}});
  worker.await_error("trying again until it can be reached");
  worker.signal(SIGTERM);
  EXPECT_EQ(worker.wait(), kDone);
}

TEST_F(StandingWorkers, AreAskedForByACoordinatorThatSaysWhoHoldsItsDomain) {
  start_worker(0, {"--pace", "2ms"});
  const auto holder = start_coordinator(kEndless);
  holder->await_error("1 worker");
  const Completed second = coppice({"learn", "-o", "second.coppice", "--episodes", "100"});
  ASSERT_EQ(second.ending, kDone);
  const Completed refused = coppice(evolve("second.coppice", {"--remote", "--domain", domain_}));
  EXPECT_EQ(refused.ending, kFailed);
  for (const std::string& part : {"domain " + domain_ + " is taken", "pid " + std::to_string(holder->pid()),
                                  std::string("coppice evolve"), std::string("--domain 203")}) {
    EXPECT_NE(refused.error.find(part), std::string::npos) << refused.error;
  }
  holder->signal(SIGINT);
  EXPECT_EQ(holder->wait(), kInterrupted);
}

TEST_F(StandingWorkers, AreNotHeldBackByAList) {
  const auto expected = serial_runs(kShort);
  start_worker(0);
  Process watching(command({"workers", "--domain", domain_, "--watch"}));
  watching.await_output("1 waiting worker");
  report_of(*start_coordinator(kShort));
  expect_same_runs("study.coppice", expected);
  watching.signal(SIGINT);
  EXPECT_EQ(watching.wait(), kDone);
}

}  // namespace
}  // namespace coppice::e2e
