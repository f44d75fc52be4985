// What a soak runs on: hosts where they can be built, a small disk, workers that come and go by one source of chance,
// and a coordinator that can be ended and resumed at any moment.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <signal.h>
#include <sys/mount.h>
#include <unistd.h>
#include <utility>

#include "tests/e2e/hosts/remote_study.hpp"

namespace coppice::e2e {

class SoakSite : public RemoteStudy {
 protected:
  static constexpr std::size_t kHosts = 3;
  static constexpr std::size_t kFewestWorkers = 2;
  static constexpr std::size_t kMostWorkers = 5;
  static constexpr std::size_t kFirstPort = 17'700;  // of workers, so that datagrams find them
  static constexpr std::size_t kPorts = 2'000;

  SoakSite() { domain_ = "205"; }
  ~SoakSite() override {
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
    make_certificates();
    write("clock", "+0");
    chains_.push_back(read("study.coppice"));
    ASSERT_EQ(coppice({"learn", "-o", "other.coppice", "--episodes", "400", "--seed", "6"}).ending, kDone);
    chains_.push_back(read("other.coppice"));
  }

  std::size_t below(std::size_t limit) { return std::uniform_int_distribution<std::size_t>(0, limit - 1)(random_); }
  void pass_up_to(std::chrono::milliseconds most) {
    let_pass(std::chrono::milliseconds(below(static_cast<std::size_t>(most.count())) + 1));
  }
  std::size_t some_host() { return hosts_ ? 2 + below(kHosts - 1) : 0; }
  std::string address(std::size_t host) const { return hosts_ ? Hosts::address(host) : "127.0.0.1"; }

  // Of some, the time of day jumps; not of those with certificates, which are valid at some times only.
  Command perhaps_with_clock(Command command) {
    return has_clocks_ && !secured_ && below(2) == 0 ? with_clock(std::move(command)) : command;
  }

  // What everybody says in an evolution is kept, to be read when it does not end as it should.
  void begin_logs(int evolution) {
    logs_ = path("logs-" + std::to_string(evolution));
    std::filesystem::create_directory(logs_);
    history_.clear();
  }
  Command logged(Command command) {
    const std::string log = logs_ + "/worker-" + std::to_string(++logged_) + ".log";
    std::vector<std::string> arguments = {"-c", R"(exec "$0" "$@" 2> ')" + log + "'", command.program};
    arguments.insert(arguments.end(), command.arguments.begin(), command.arguments.end());
    command.program = "/bin/sh";
    command.arguments = std::move(arguments);
    return command;
  }
  void keep_coordinators_log() {
    if (coordinator_ != nullptr) {
      std::ofstream(logs_ + "/coordinator.log", std::ios::app) << coordinator_->rest_of_error() << "-- ended\n";
    }
  }
  std::string all_logs() {
    keep_coordinators_log();
    std::string all = history_ + "\n";
    for (const auto& entry : std::filesystem::directory_iterator(logs_)) {
      std::ifstream file(entry.path());
      all += "== " + entry.path().filename().string() + "\n" + std::string(std::istreambuf_iterator<char>(file), {});
    }
    return all;
  }
  // Those of an evolution that went well go, unless a folder for them is named.
  void end_logs(bool well) {
    if (const char* const folder = std::getenv("COPPICE_SOAK_LOGS"); folder != nullptr) {
      keep_coordinators_log();
      std::filesystem::create_directories(folder);
      std::filesystem::copy(
          logs_, std::filesystem::path(folder) / std::filesystem::path(logs_).filename(),
          std::filesystem::copy_options::recursive | std::filesystem::copy_options::overwrite_existing);
    }
    if (well) {
      std::filesystem::remove_all(logs_);
    }
  }

  // Also again: identities of everybody, other keys too.
  void make_certificates() const {
    const Completed made = run_to_end(
        {.program = COPPICE_SOURCE_DIR "/deploy/security/make-certificates.sh", .arguments = {path("ours")}});
    ASSERT_EQ(made.ending, kDone) << made.error;
  }
  // Standing workers serve one evolution after another, until one is secured as the last was not.
  void choose_security() {
    const bool secured = all_secured_ || below(2) == 0;
    if (std::exchange(secured_, secured) != secured) {
      workers_.clear();
      doors_.clear();
    }
  }
  // Those who run hold what they read when they started; new ones read the new files.
  void rotate_certificates() {
    make_certificates();
    for (std::size_t left = workers_.size(); left > 0; --left) {
      workers_.front()->signal(SIGTERM);
      workers_.front()->wait();
      remove_worker(0);
      add_worker();
      pass_up_to(std::chrono::milliseconds(300));
    }
    end_coordinator(SIGTERM);
  }
  // As Slurm does: the coordinator is lost and resumed on another host, where all workers follow it.
  void requeue_coordinator() {
    coordinator_->signal(SIGKILL);
    coordinator_->wait();
    coordinator_host_ = 1 + below(kHosts);
    for (std::size_t left = workers_.size(); left > 0; --left) {
      remove_worker(0);
      add_worker();
    }
    resume();
  }

  void add_worker() {
    const std::size_t host = some_host();
    const std::string port = std::to_string(kFirstPort + next_port_++ % kPorts);
    std::vector<std::string> flags = {"--pace",      std::to_string(200 + below(2000)) + "us",
                                      "--threads",   std::to_string(1 + below(2)),
                                      "--port",      port,
                                      "--log-level", "warn"};
    if (secured_) {
      flags.insert(flags.end(), {"--security", path("ours/worker")});
    }
    workers_.push_back(std::make_unique<Process>(there(host, perhaps_with_clock(logged(worker(std::move(flags)))))));
    doors_.push_back(address(host) + ":" + port);
  }
  void remove_worker(std::size_t which) {
    workers_.erase(workers_.begin() + static_cast<std::ptrdiff_t>(which));
    doors_.erase(doors_.begin() + static_cast<std::ptrdiff_t>(which));
  }
  void fill_up() {
    while (workers_.size() < kFewestWorkers) {
      add_worker();
    }
  }

  void coordinate(std::vector<std::string> more) {
    std::vector<std::string> flags = {
        "--remote", "--domain", domain_, "--lines-every", "1", "--cross-check", all_checked_ ? "1" : "0.01"};
    if (hosts_) {
      flags.insert(flags.end(), {"--interface", "eth0"});
    }
    if (secured_) {
      flags.insert(flags.end(), {"--security", path("ours/coordinator")});
    }
    flags.insert(flags.end(), more.begin(), more.end());
    std::vector<std::string> arguments = evolve("disk/study.coppice", flags);
    keep_coordinators_log();
    coordinator_ =
        std::make_unique<Process>(there(coordinator_host_, perhaps_with_clock(command(std::move(arguments)))));
  }

  void replace_worker(int signal) {
    const std::size_t which = below(workers_.size());
    workers_[which]->signal(signal);
    workers_[which]->wait();
    remove_worker(which);
    pass_up_to(std::chrono::milliseconds(300));
    fill_up();
  }

  void let_in(const char* program, std::vector<std::string> arguments) {
    Command stranger{.program = program, .arguments = std::move(arguments)};
    stranger.environment = {{"COPPICE_STRANGER_HOST", address(coordinator_host_)}};
    strangers_.push_back(std::make_unique<Process>(there(some_host(), stranger)));
  }

  void fill_disk_for_a_while() {
    {
      std::ofstream filler(path("disk/filler"), std::ios::binary);
      const std::string block(4096, 'x');
      while (filler.write(block.data(), static_cast<std::streamsize>(block.size())).flush()) {
      }
    }
    pass_up_to(std::chrono::milliseconds(500));
    std::filesystem::remove(path("disk/filler"));
    disk_was_full_ = true;
    if (!coordinator_->running()) {
      resume();
    }
  }
  // A coordinator that met a full disk may take its time to end, and is resumed then.
  bool resumed_after_full_disk() {
    if (!disk_was_full_) {
      return false;
    }
    disk_was_full_ = false;
    coordinator_->wait();
    const bool ended = status() == "finished";
    if (!ended) {
      coordinate({"--resume"});
    }
    return !ended;
  }

  void end_coordinator(int signal) {
    coordinator_->signal(signal);
    resume();
  }
  // Unless it had ended its run already.
  void resume() {
    coordinator_->wait();
    if (status() != "finished") {
      coordinate({"--resume"});
    }
  }

  std::string status() const {
    const auto list = coppice_json({"info", "disk/study.coppice", "--json"})["runs"];
    return list.empty() ? "none" : list.back()["status"].get<std::string>();
  }

  const bool all_secured_ = std::getenv("COPPICE_SOAK_SECURITY") != nullptr;
  bool secured_ = all_secured_;
  std::string logs_;  // folder
  std::size_t logged_ = 0;
  std::string history_;  // of faults, in this evolution
  std::mt19937 random_;
  std::vector<std::string> chains_;  // studies, not evolved yet
  std::unique_ptr<Process> coordinator_;
  bool all_checked_ = false;
  bool disk_was_full_ = false;      // in this evolution, since a coordinator was last resumed for it
  std::vector<std::string> doors_;  // of each worker: address and port
  std::size_t next_port_ = 0;
  std::vector<std::unique_ptr<Process>> strangers_;
  const bool has_clocks_ = std::filesystem::exists(kFakeTime);
  bool mounted_ = false;
};

}  // namespace coppice::e2e
