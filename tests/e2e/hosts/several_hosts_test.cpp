// Several hosts, with what their network does to them: the evolution ends with the serial result, bit for bit.
#include "tests/e2e/hosts/remote_study.hpp"

namespace coppice::e2e {
namespace {

using namespace std::chrono_literals;

// A generation takes 2 workers at this pace about 50 ms, so that faults of seconds fall into an evolution.
const std::vector<std::string> kPace = {"--pace", "2ms"};
const std::vector<std::string> kShort = {"--seed", "4", "--set", "ga.generations=60"};
const std::vector<std::string> kLong = {"--seed", "4", "--set", "ga.generations=120"};

class SeveralHosts : public RemoteStudy {
 protected:
  void SetUp() override {
    build_hosts(3);
    if (!IsSkipped()) {
      RemoteStudy::SetUp();
    }
  }

  // Workers on hosts 2 and 3, and a whole evolution with them.
  nlohmann::json evolve_with(const std::vector<std::string>& settings, const std::vector<std::string>& network = {}) {
    expected_ = serial_runs(settings);
    start_worker(2, network);
    start_worker(3, network);
    std::vector<std::string> more = settings;
    more.insert(more.end(), network.begin(), network.end());
    return report_of(*start_coordinator(more));
  }

  void expect_serial_result() const { expect_same_runs("study.coppice", expected_); }

  nlohmann::json expected_;
};

TEST_F(SeveralHosts, EvolveTheSerialResult) {
  expected_ = serial_runs(kShort);
  start_worker(2, kPace);
  start_worker(3, kPace);
  const auto coordinator = start_coordinator(kShort);
  coordinator->await_error("2 workers");  // both had a part in it
  EXPECT_EQ(report_of(*coordinator)["dispatch"]["workers_lost"], 0);
  expect_serial_result();
}

TEST_F(SeveralHosts, NeedOneOpenPortAtTheCoordinatorAndOneAtEachWorker) {
  hosts_->admit_only(1, "udp dport 7410 accept");
  hosts_->admit_only(2, "ip saddr " + Hosts::address(1) + " udp dport 7500 accept");
  hosts_->admit_only(3, "ip saddr " + Hosts::address(1) + " udp dport 7500 accept");
  expected_ = serial_runs(kShort);
  start_worker(2, {"--port", "7500"});
  start_worker(3, {"--port", "7500"});
  report_of(*start_coordinator(kShort));
  expect_serial_result();
}

TEST_F(SeveralHosts, EvolveTheSerialResultThoughALinkIsDownForFiveSeconds) {
  expected_ = serial_runs(kLong);
  start_worker(2, kPace);
  start_worker(3, kPace);
  const auto coordinator = start_coordinator(kLong);
  coordinator->await_error("2 workers");
  hosts_->set_link(2, false);
  let_pass(5s);
  hosts_->set_link(2, true);
  coordinator->await_error(" 1 worker");
  coordinator->await_error("2 workers");  // it came back by itself
  EXPECT_GE(report_of(*coordinator)["dispatch"]["workers_lost"], 1);
  expect_serial_result();
}

TEST_F(SeveralHosts, EvolveTheSerialResultThoughEveryLinkIsDownForFiveSeconds) {
  expected_ = serial_runs(kLong);
  start_worker(2, kPace);
  start_worker(3, kPace);
  const auto coordinator = start_coordinator(kLong);
  coordinator->await_error("2 workers");
  hosts_->set_link(1, false);
  let_pass(5s);
  hosts_->set_link(1, true);
  EXPECT_GE(report_of(*coordinator)["dispatch"]["workers_lost"], 2);
  expect_serial_result();
}

TEST_F(SeveralHosts, EvolveTheSerialResultAcrossALinkThatLosesAndDelays) {
  hosts_->lose(5);
  hosts_->delay(2, 20);
  evolve_with(kShort, {"--lossy"});
  expect_serial_result();
}

TEST_F(SeveralHosts, EvolveTheSerialResultAcrossALossyLinkEvenUnprepared) {
  hosts_->lose(5);
  evolve_with({"--seed", "4", "--set", "ga.generations=20"});
  expect_serial_result();
}

TEST_F(SeveralHosts, EvolveTheSerialResultWhereOnlySmallPacketsPass) {
  for (std::size_t host = 1; host <= 3; ++host) {
    hosts_->set_mtu(host, 1280);
  }
  hosts_->drop_fragments();
  evolve_with(kShort, {"--lossy"});
  expect_serial_result();
}

TEST_F(SeveralHosts, EvolveTheSerialResultWithPacketsCutToPieces) {
  for (std::size_t host = 1; host <= 3; ++host) {
    hosts_->set_mtu(host, 576);
  }
  evolve_with(kShort);
  expect_serial_result();
}

}  // namespace
}  // namespace coppice::e2e
