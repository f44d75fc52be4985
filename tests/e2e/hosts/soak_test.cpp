// Chaos: evolutions over workers on several hosts (over the loopback interface where there can be none), with faults
// of every kind at random moments, all from one seed that is printed. Each evolution must end with the serial result,
// bit for bit. A short one is part of the suite; tests/e2e/soak runs it for as long as one likes.
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <map>
#include <random>
#include <signal.h>
#include <sys/mount.h>

#include "tests/e2e/hosts/remote_study.hpp"

namespace coppice::e2e {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t kHosts = 3;
constexpr std::size_t kFewestWorkers = 2;
constexpr std::size_t kMostWorkers = 5;

double minutes_asked() {
  const char* text = std::getenv("COPPICE_SOAK_MINUTES");
  return text != nullptr ? std::strtod(text, nullptr) : 0.2;
}

std::uint32_t seed_asked() {
  const char* text = std::getenv("COPPICE_SOAK_SEED");
  return text != nullptr ? static_cast<std::uint32_t>(std::strtoul(text, nullptr, 10)) : std::random_device{}();
}

class Soak : public RemoteStudy {
 protected:
  Soak() { domain_ = "205"; }
  ~Soak() override {
    if (mounted_) {
      umount2(path("disk").c_str(), MNT_DETACH);
    }
  }

  void SetUp() override {
    if (!Hosts::why_not()) {
      hosts_ = std::make_unique<Hosts>(kHosts);
    }
    RemoteStudy::SetUp();
    std::filesystem::create_directory(path("disk"));
    mounted_ = geteuid() == 0 && mount("coppice-soak", path("disk").c_str(), "tmpfs", 0, "size=64m") == 0;
    learned_ = read("study.coppice");
  }

  std::size_t below(std::size_t limit) { return std::uniform_int_distribution<std::size_t>(0, limit - 1)(random_); }
  void pass_up_to(std::chrono::milliseconds most) {
    let_pass(std::chrono::milliseconds(below(static_cast<std::size_t>(most.count())) + 1));
  }
  std::size_t some_host() { return hosts_ ? 2 + below(kHosts - 1) : 0; }

  void add_worker() {
    start_worker(some_host(), {"--pace", std::to_string(200 + below(2000)) + "us", "--threads",
                               std::to_string(1 + below(2)), "--log-level", "off"});
  }

  std::unique_ptr<Process> coordinate(std::vector<std::string> more) {
    std::vector<std::string> arguments =
        evolve("disk/study.coppice", {"--remote", "--domain", domain_, "--lines-every", "1"});
    if (hosts_) {
      arguments.insert(arguments.end(), {"--interface", "eth0"});
    }
    arguments.insert(arguments.end(), more.begin(), more.end());
    return std::make_unique<Process>(there(kCoordinatorHost, command(std::move(arguments))));
  }

  // The last fault of a kind ends when the next thing happens, so that nothing is away for good.
  void do_something(std::unique_ptr<Process>& coordinator) {
    static const std::vector<std::string> kFaults = {
        "worker killed",      "worker stopped",     "worker left", "worker added",
        "all workers killed", "coordinator killed", "link down",   "packets lost",
        "stranger",           "disk full",          "liar",        "coordinator asked to stop"};
    const std::string fault = kFaults[below(kFaults.size())];
    if ((!hosts_ && (fault == "link down" || fault == "packets lost")) || (!mounted_ && fault == "disk full")) {
      return;
    }
    ++faults_[fault];
    if (fault == "worker killed") {
      replace_worker(SIGKILL);
    } else if (fault == "worker left") {
      replace_worker(SIGTERM);
    } else if (fault == "worker stopped") {
      Process& worker = *workers_[below(workers_.size())];
      worker.signal(SIGSTOP);
      pass_up_to(4s);
      worker.signal(SIGCONT);
    } else if (fault == "worker added" && workers_.size() < kMostWorkers) {
      add_worker();
    } else if (fault == "all workers killed") {
      workers_.clear();
      pass_up_to(2s);
      fill_up();
    } else if (fault == "coordinator killed" || fault == "coordinator asked to stop") {
      coordinator->signal(fault == "coordinator killed" ? SIGKILL : SIGINT);
      resume(coordinator);
    } else if (fault == "link down") {
      const std::size_t host = 1 + below(kHosts);
      hosts_->set_link(host, false);
      pass_up_to(5s);
      hosts_->set_link(host, true);
    } else if (fault == "packets lost") {
      hosts_->lose(static_cast<int>(1 + below(20)));
      pass_up_to(3s);
      hosts_->lose(0);
    } else if (fault == "stranger") {
      Command stranger{.program = COPPICE_STRANGER, .arguments = {domain_, "knock"}};
      stranger.environment = {{"COPPICE_STRANGER_HOST", hosts_ ? Hosts::address(1) : "127.0.0.1"}};
      strangers_.push_back(std::make_unique<Process>(there(some_host(), stranger)));
    } else if (fault == "liar") {
      Command liar{.program = COPPICE_LIAR, .arguments = {domain_, "0"}};
      liar.environment = {{"COPPICE_STRANGER_HOST", hosts_ ? Hosts::address(1) : "127.0.0.1"}};
      strangers_.push_back(std::make_unique<Process>(there(some_host(), liar)));
    } else if (fault == "disk full") {
      fill_disk();
      pass_up_to(500ms);
      std::filesystem::remove(path("disk/filler"));
      if (!coordinator->running()) {
        resume(coordinator);
      }
    }
  }

  void replace_worker(int signal) {
    const std::size_t which = below(workers_.size());
    workers_[which]->signal(signal);
    workers_[which]->wait();
    workers_.erase(workers_.begin() + static_cast<std::ptrdiff_t>(which));
    pass_up_to(300ms);
    fill_up();
  }

  void fill_up() {
    while (workers_.size() < kFewestWorkers) {
      add_worker();
    }
  }

  void fill_disk() const {
    std::ofstream filler(path("disk/filler"), std::ios::binary);
    const std::string block(4096, 'x');
    while (filler.write(block.data(), static_cast<std::streamsize>(block.size())).flush()) {
    }
  }

  // Until it runs, or had ended its run already.
  void resume(std::unique_ptr<Process>& coordinator) {
    coordinator->wait();
    if (status() != "finished") {
      coordinator = coordinate({"--resume"});
    }
  }

  std::string status() const {
    const auto list = coppice_json({"info", "disk/study.coppice", "--json"})["runs"];
    return list.empty() ? "none" : list.back()["status"].get<std::string>();
  }

  // One evolution. Returns how many faults it saw.
  void evolve_under_fire() {
    const std::vector<std::string> settings = {
        "--seed", std::to_string(1 + below(1000)), "--set", "ga.generations=250", "--set", "ga.population=60"};
    write("study.coppice", learned_);
    std::filesystem::remove(path("serial.coppice"));
    const auto expected = serial_runs(settings);
    write("disk/study.coppice", learned_);
    fill_up();
    auto coordinator = coordinate(settings);
    coordinator->await_error("evolve: ");  // the run is in the study: it can be resumed
    while (coordinator->running()) {
      pass_up_to(700ms);
      if (coordinator->running()) {
        do_something(coordinator);
      }
    }
    const Ending ending = coordinator->wait();
    ASSERT_EQ(status(), "finished") << "ended with " << ending.exit_code.value_or(-1) << ": "
                                    << coordinator->rest_of_error();
    expect_same_runs("disk/study.coppice", expected);
    strangers_.clear();
  }

  std::string learned_;
  std::mt19937 random_;
  std::map<std::string, int> faults_;
  std::vector<std::unique_ptr<Process>> strangers_;
  bool mounted_ = false;
};

TEST_F(Soak, EveryEvolutionEndsWithTheSerialResultWhateverHappens) {
  const std::uint32_t seed = seed_asked();
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(minutes_asked() * 60);
  std::cout << "soak of " << minutes_asked() << " minutes, seed " << seed
            << (hosts_ ? ", on several hosts" : ", on one host") << std::endl;
  random_.seed(seed);
  int evolutions = 0;
  while (std::chrono::steady_clock::now() < end && !HasFatalFailure() && !HasNonfatalFailure()) {
    evolve_under_fire();
    ++evolutions;
  }
  std::cout << evolutions << " evolutions, each with the serial result; faults:";
  for (const auto& [fault, count] : faults_) {
    std::cout << ' ' << fault << ' ' << count << ';';
  }
  std::cout << std::endl;
}

}  // namespace
}  // namespace coppice::e2e
