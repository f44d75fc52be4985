// An evolution that a coordinator on one host does with workers on others, or all on this machine's loopback
// interface, and the serial one that it must equal.
#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "tests/e2e/cli/evolved_study.hpp"
#include "tests/e2e/hosts/hosts.hpp"

namespace coppice::e2e {

class RemoteStudy : public EvolvedStudy {
 protected:
  static constexpr std::size_t kCoordinatorHost = 1;

  // REQUIRES: before anything is started. Skips the test where there can be no hosts.
  void build_hosts(std::size_t count) {
    if (const auto why = Hosts::why_not()) {
      GTEST_SKIP() << *why;
    }
    hosts_ = std::make_unique<Hosts>(count);
  }

  // On this host, or on this machine when there are none.
  Command there(std::size_t host, Command command) const { return hosts_ ? hosts_->on(host, command) : command; }

  Command worker(std::vector<std::string> more = {}) const {
    std::vector<std::string> arguments = {"--coordinator", hosts_ ? Hosts::address(coordinator_host_) : "127.0.0.1",
                                          "--domain", domain_};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return {.program = COPPICE_WORKER_PROGRAM, .arguments = std::move(arguments)};
  }
  Process& start_worker(std::size_t host, std::vector<std::string> more = {}) {
    workers_.push_back(std::make_unique<Process>(there(host, worker(std::move(more)))));
    return *workers_.back();
  }

  Command coordinator(std::vector<std::string> more) const {
    std::vector<std::string> flags = {"--remote", "--domain", domain_, "--lines-every", "1", "--json", "--wait", wait_};
    if (hosts_) {
      flags.insert(flags.end(), {"--interface", "eth0"});
    }
    flags.insert(flags.end(), more.begin(), more.end());
    return there(coordinator_host_, command(evolve("study.coppice", flags)));
  }
  std::unique_ptr<Process> start_coordinator(const std::vector<std::string>& more) const {
    return std::make_unique<Process>(coordinator(more));
  }

  // Its clock is off by what the file "clock" says ("+3600"): the time of day, not the one that only goes on. REQUIRES:
  // kFakeTime exists.
  static constexpr const char* kFakeTime = "/usr/lib/x86_64-linux-gnu/faketime/libfaketimeMT.so.1";
  Command with_clock(Command command) const {
    command.environment.insert(command.environment.end(), {{"LD_PRELOAD", kFakeTime},
                                                           {"FAKETIME_TIMESTAMP_FILE", path("clock")},
                                                           {"FAKETIME_NO_CACHE", "1"},
                                                           {"FAKETIME_DONT_FAKE_MONOTONIC", "1"},
                                                           {"DONT_FAKE_MONOTONIC", "1"}});
    return command;
  }

  // Waits for its end, which must be a good one. Returns its report.
  static nlohmann::json report_of(Process& coordinator) {
    const Ending ending = coordinator.wait();
    const std::string said = coordinator.rest_of_error();
    EXPECT_EQ(ending, kDone) << said;
    return nlohmann::json::parse(coordinator.rest_of_output(), nullptr, false);
  }

  std::unique_ptr<Hosts> hosts_;
  std::size_t coordinator_host_ = kCoordinatorHost;
  std::string domain_ = "0";
  std::string wait_ = "60";  // seconds
  std::vector<std::unique_ptr<Process>> workers_;
};

// How long a fault lasts: part of the fault, no synchronisation.
inline void let_pass(std::chrono::milliseconds time) { std::this_thread::sleep_for(time); }

}  // namespace coppice::e2e
