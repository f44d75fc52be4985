// Networks that are not one flat IPv4: IPv6, a forwarded port, two interfaces.
#include <signal.h>

#include "tests/e2e/hosts/remote_study.hpp"

namespace coppice::e2e {
namespace {

const std::vector<std::string> kShort = {"--seed", "4", "--set", "ga.generations=20"};

class Addresses : public RemoteStudy {
 protected:
  void SetUp() override {
    build_hosts(3);
    if (!IsSkipped()) {
      RemoteStudy::SetUp();
    }
  }

  Process& start_worker_of(std::size_t host, const std::string& coordinators_address) {
    workers_.push_back(std::make_unique<Process>(
        there(host, {.program = COPPICE_WORKER_PROGRAM, .arguments = {"--coordinator", coordinators_address}})));
    return *workers_.back();
  }
  std::unique_ptr<Process> coordinate(const std::string& interface, std::vector<std::string> more) const {
    std::vector<std::string> flags = {"--remote", "--interface", interface, "--json", "--wait", wait_};
    if (more.empty() || more.front() != "--resume") {
      flags.insert(flags.end(), kShort.begin(), kShort.end());
    }
    flags.insert(flags.end(), more.begin(), more.end());
    return std::make_unique<Process>(there(kCoordinatorHost, command(evolve("study.coppice", flags))));
  }
  void expect_serial_result_over(const std::string& interface, const std::string& address,
                                 const std::vector<std::string>& more = {}) {
    const auto expected = serial_runs(kShort);
    start_worker_of(2, address);
    start_worker_of(3, address);
    report_of(*coordinate(interface, more));
    expect_same_runs("study.coppice", expected);
  }
};

TEST_F(Addresses, MayBeOfIpv6) {
  hosts_->use_ipv6_only();
  expect_serial_result_over("eth0", Hosts::address6(1));
}

TEST_F(Addresses, MayBeLinkLocalWithTheirInterface) {
  hosts_->use_ipv6_only();
  expect_serial_result_over(Hosts::link_local(1) + "%eth0", Hosts::link_local(1) + "%eth0");
}

TEST_F(Addresses, ThatAreLinkLocalNeedTheirInterface) {
  hosts_->use_ipv6_only();
  Process& worker = start_worker_of(2, Hosts::link_local(1));
  worker.await_error("fe80::99:1 is link-local: expected the interface that leads there with it, as fe80::99:1%eth0");
}

TEST_F(Addresses, ListWorkersOfIpv6) {
  hosts_->use_ipv6_only();
  start_worker_of(2, Hosts::address6(1));
  std::string listed;
  for (int i = 0; i < 30 && listed.find("1 waiting worker") == std::string::npos; ++i) {
    listed = run_to_end(there(kCoordinatorHost, command({"workers", "--interface", "eth0"}))).output;
  }
  EXPECT_NE(listed.find("1 waiting worker"), std::string::npos) << listed;
}

TEST_F(Addresses, MayBeThoseOfARouterThatForwardsThePort) {
  hosts_->hide_behind(2, 1, 7410);
  const auto expected = serial_runs(kShort);
  start_worker_of(3, Hosts::address(2));
  wait_ = "5";
  const auto untold = coordinate("eth0", {});
  EXPECT_EQ(untold->wait(), kNoWorker) << "reached without --advertise: what does it do, then?";
  wait_ = "60";
  report_of(*coordinate("eth0", {"--resume", "--advertise", Hosts::address(2)}));
  auto found = runs("study.coppice");
  EXPECT_EQ(found, expected);
}

TEST_F(Addresses, OfASecondInterfaceServeThoseWhoHaveARouteToTheFirst) {
  hosts_->join_directly(1, 3);
  hosts_->set_link(3, false);
  hosts_->ip_on(3, "-4 addr flush dev eth0");
  const auto expected = serial_runs(kShort);
  start_worker_of(3, "10.97.0.1");
  wait_ = "5";
  EXPECT_EQ(coordinate("eth0", {})->wait(), kNoWorker);
  hosts_->ip_on(3, "route add " + Hosts::address(1) + " via 10.97.0.1");
  wait_ = "60";
  report_of(*coordinate("eth0", {"--resume"}));
  EXPECT_EQ(runs("study.coppice"), expected);
}

TEST_F(Addresses, ThatAreAdvertisedMustBeAddresses) {
  const auto refused = coordinate("eth0", {"--advertise", "router"});
  EXPECT_EQ(refused->wait(), kWrongUse);
  EXPECT_NE(refused->rest_of_error().find("--advertise is router: expected an IPv4 address"), std::string::npos);
}

}  // namespace
}  // namespace coppice::e2e
