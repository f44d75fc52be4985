// What a supervisor is told of a worker: readiness, a watchdog's sign of life, health, and why no coordinator is there.
#include <climits>
#include <signal.h>
#include <sys/socket.h>
#include <sys/un.h>

#include "tests/e2e/hosts/watching.hpp"

namespace coppice::e2e {
namespace {

const std::vector<std::string> kEndless = {"--seed", "4", "--set", "ga.generations=100000"};

// A service manager's end of NOTIFY_SOCKET.
class NotifySocket {
 public:
  explicit NotifySocket(const std::string& path) : socket_(socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, sizeof address.sun_path - 1);
    EXPECT_EQ(bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    const timeval patience{.tv_sec = kPatience.count(), .tv_usec = 0};
    setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  }
  NotifySocket(const NotifySocket&) = delete;
  NotifySocket& operator=(const NotifySocket&) = delete;
  ~NotifySocket() { close(socket_); }

  // Reads on until a message begins so. Returns how many others came before.
  int await(const std::string& beginning) {
    for (int others = 0;; ++others) {
      char buffer[1024];
      const ssize_t count = recv(socket_, buffer, sizeof buffer, 0);
      if (count <= 0) {
        ADD_FAILURE() << "never heard " << beginning;
        return others;
      }
      if (std::string(buffer, static_cast<std::size_t>(count)).rfind(beginning, 0) == 0) {
        return others;
      }
    }
  }

 private:
  int socket_;
};

class Supervision : public Watching {
 protected:
  Supervision() { domain_ = "209"; }

  static Completed ask(const std::string& port) {
    return run_to_end({.program = COPPICE_WORKER_PROGRAM, .arguments = {"--health", port}});
  }
};

TEST_F(Supervision, TellsSystemdWhatAWorkerDoes) {
  NotifySocket manager(path("notify"));
  Command standing = worker();
  standing.environment = {{"NOTIFY_SOCKET", path("notify")}, {"WATCHDOG_USEC", "600000"}};
  Process process(standing);
  manager.await("READY=1");
  manager.await("STATUS=waiting for a coordinator at 127.0.0.1");
  for (int i = 0; i < 3; ++i) {
    manager.await("WATCHDOG=1");
  }
  const auto coordinator = start_coordinator(kEndless);
  manager.await("STATUS=serving the coordinator");
  manager.await("WATCHDOG=1");
  coordinator->signal(SIGKILL);
  coordinator->wait();
  manager.await("STATUS=waiting for a coordinator");
  process.signal(SIGTERM);
  manager.await("STOPPING=1");
  EXPECT_EQ(process.wait(), kDone);
}

TEST_F(Supervision, AsksAWorkerForItsHealth) {
  Process& standing = start_worker(0, {"--metrics", "0"});
  const std::string port = port_of(standing);
  Completed waits = ask(port);
  while (waits.output.find("waiting for a coordinator at 127.0.0.1") == std::string::npos) {  // it is starting
    ASSERT_EQ(waits.ending, kDone) << waits.output;
    waits = ask(port);
  }
  EXPECT_EQ(waits.ending, kDone) << waits.output;
  standing.signal(SIGSTOP);            // as one that hangs
  while (ask(port).ending == kDone) {  // the signal reaches its threads one by one
  }
  EXPECT_EQ(ask(port).ending, kFailed);
  standing.signal(SIGCONT);
  EXPECT_EQ(ask(port).ending, kDone);
  standing.signal(SIGTERM);
  EXPECT_EQ(standing.wait(), kDone);
  const Completed gone = ask(port);
  EXPECT_EQ(gone.ending, kFailed);
  EXPECT_NE(gone.output.find("Connection refused"), std::string::npos) << gone.output;
}

TEST_F(Supervision, SaysThatNothingListensWhereAWorkerKnocks) {
  Process& lonely = start_worker(0);
  const std::string said = lonely.await_error("no coordinator at 127.0.0.1 (UDP port 59660) for 1");
  EXPECT_NE(said.find("nothing listens there: none runs just now, or in another --domain than 209"), std::string::npos)
      << said;
}

class SupervisionAcrossHosts : public Supervision {
 protected:
  void SetUp() override {
    build_hosts(3);
    domain_ = "0";
    if (!IsSkipped()) {
      RemoteStudy::SetUp();
    }
  }
};

TEST_F(SupervisionAcrossHosts, BothSidesNameTheFirewallThatKeepsThemApart) {
  hosts_->admit_only(1, "tcp dport 22 accept");
  Process& lonely = start_worker(2);
  const auto coordinator = start_coordinator(kEndless);
  const std::string hint = coordinator->await_error("no worker is there; waiting");
  EXPECT_NE(hint.find("Start one: coppice-worker --coordinator 10.99.0.1 --domain 0"), std::string::npos) << hint;
  EXPECT_NE(hint.find("UDP port 7410 of eth0 (firewall"), std::string::npos) << hint;
  const std::string said = lonely.await_error("no coordinator at 10.99.0.1 (UDP port 7410) for 1");
  EXPECT_NE(said.find("it neither answers nor refuses: a firewall (UDP port 7410 there"), std::string::npos) << said;
}

TEST_F(SupervisionAcrossHosts, ListsWorkersThroughAFirewallByAPortOfOnesOwn) {
  hosts_->admit_only(3, "ip saddr " + Hosts::address(1) + " udp dport 7600 accept");
  start_worker(2, {"--pace", "2ms"});
  const auto coordinator = start_coordinator(kEndless);
  coordinator->await_error("1 worker");
  const auto list = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"workers", "--coordinator", Hosts::address(1)});
    return run_to_end(there(3, command(std::move(more))));
  };
  const Completed without = list({});
  EXPECT_EQ(without.ending, kFailed);
  const Completed with = list({"--port", "7600"});
  EXPECT_EQ(with.ending, kDone) << with.error;
  EXPECT_NE(with.output.find("1 worker"), std::string::npos) << with.output;
}

}  // namespace
}  // namespace coppice::e2e
