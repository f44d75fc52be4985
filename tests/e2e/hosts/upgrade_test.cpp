// The runbook of an upgrade (deploy/README.md): workers of two versions and a coordinator of one, under supervisors
// that start whatever ends, as systemd does; programs are replaced under them. Nothing is lost, and nobody is left
// behind.
#include <signal.h>

#include "tests/e2e/hosts/remote_study.hpp"

namespace coppice::e2e {
namespace {

const std::vector<std::string> kSettings = {"--seed", "4", "--set", "ga.generations=400"};

class Upgrade : public RemoteStudy {
 protected:
  Upgrade() { domain_ = "211"; }

  // From now on the program that supervisors start under this name.
  void install(const std::string& name, const std::string& line) const {
    write(name + ".new", "#!/bin/sh\nexec " + line + "\n");
    std::filesystem::permissions(path(name + ".new"), std::filesystem::perms::owner_all);
    std::filesystem::rename(path(name + ".new"), path(name));
  }
  std::string flags() const { return " --coordinator 127.0.0.1 --domain " + domain_; }
  void install_other(const std::string& name, const std::string& how) const {
    install(name, std::string(COPPICE_OTHER_VERSION) + " " + how + flags());
  }
  void install_this(const std::string& name) const {
    install(name, std::string(COPPICE_WORKER_PROGRAM) + flags() + " --pace 1ms");
  }
  // Restart=always. `ended` lines tell of each end.
  Process& supervise(const std::string& name) {
    workers_.push_back(std::make_unique<Process>(
        Command{.program = "/bin/sh",
                .arguments = {"-c", "trap 'kill $! 2> /dev/null; exit 0' TERM; while true; do ./" + name +
                                        " & wait $!; echo \"ended with $?\" >&2; sleep 0.2 & wait $!; done"},
                .folder = path("."),
                .environment = {}}));
    return *workers_.back();
  }
  ~Upgrade() override {
    for (const auto& worker : workers_) {
      worker->signal(SIGTERM);
      worker->wait();
    }
  }
};

TEST_F(Upgrade, OldWorkersAreRefusedByANewCoordinatorUntilTheyAreUpgradedOneByOne) {
  install_other("one", "protocol");
  install_other("two", "build");
  Process& one = supervise("one");
  Process& two = supervise("two");
  const auto expected = serial_runs(kSettings);
  const auto coordinator = start_coordinator(kSettings);
  one.await_error("install the same version of Coppice on both");
  one.await_error("ended with 1");
  two.await_error("computes otherwise than this worker (version 0.9.9)");
  two.await_error("ended with 1");
  coordinator->await_error("refused: see above");
  install_this("one");
  coordinator->await_error("1 worker");
  install_this("two");
  coordinator->await_error("2 workers");
  EXPECT_EQ(report_of(*coordinator)["dispatch"]["workers_lost"], 0);
  expect_same_runs("study.coppice", expected);
}

TEST_F(Upgrade, NewWorkersDoNotDisturbAnOldCoordinatorAndTakeOverAfterIt) {
  install_this("old");
  install_other("new", "protocol");
  supervise("old");
  const auto expected = serial_runs(kSettings);
  const auto coordinator = start_coordinator(kSettings);
  coordinator->await_error("1 worker");
  Process& early = supervise("new");
  early.await_error("ended with 1");
  early.await_error("ended with 1");  // it tries again and again
  coordinator->signal(SIGTERM);       // the coordinator's turn: its study keeps what was done
  EXPECT_EQ(coordinator->wait(), kInterrupted);
  install_this("new");  // stands for a coordinator of the new version: both are of one version again
  const auto resumed = start_coordinator({"--resume"});
  resumed->await_error("2 workers");
  report_of(*resumed);
  expect_same_runs("study.coppice", expected);
}

}  // namespace
}  // namespace coppice::e2e
