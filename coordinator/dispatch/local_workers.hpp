// Worker processes of this coordinator on this machine: started, watched, replaced when they die, and reaped. Each is
// in a process group of its own, so that Ctrl-C reaches the coordinator alone, and dies with the coordinator even when
// that is killed. One thread uses it.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <sys/types.h>
#include <vector>

#include "common/error.hpp"

namespace coppice {

class LocalWorkers {
 public:
  // Of each worker in a row; more than an individual needs to count as poisonous.
  static constexpr int kMaxRestarts = 6;
  static constexpr std::size_t kMaxWorkers = 1024;

  // Starts workers of `program` for the coordinator of this machine in `domain`: one for each list of flags, which it
  // gets beside those that bring it here.
  // REQUIRES: the calling thread lives as long as the workers: they die with it. Errors: the program cannot be
  // started (those that were are stopped).
  using Flags = std::vector<std::string>;
  static Result<LocalWorkers> start(const std::filesystem::path& program, const std::vector<Flags>& flags,
                                    std::uint32_t domain);
  static Result<LocalWorkers> start(const std::filesystem::path& program, std::size_t count, std::uint32_t domain) {
    return start(program, std::vector<Flags>(count), domain);
  }

  LocalWorkers(LocalWorkers&& other) noexcept;
  LocalWorkers& operator=(LocalWorkers&&) = delete;
  LocalWorkers(const LocalWorkers&) = delete;
  LocalWorkers& operator=(const LocalWorkers&) = delete;
  // SIGTERM to all, 1.5 s later SIGKILL to those still there; reaps every one.
  ~LocalWorkers();

  // Reaps workers that ended and starts others in their place, kMaxRestarts times each unless they lived long enough.
  // Never blocks. Returns which ended, with a line for the log.
  struct Ended {
    pid_t pid = 0;
    std::string what;
  };
  std::vector<Ended> tend();

  // Those that run.
  std::vector<pid_t> pids() const;
  std::size_t running() const { return pids().size(); }

 private:
  struct Worker {
    pid_t pid = 0;  // 0: given up
    Flags flags;
    int restarts = 0;  // in a row
    std::chrono::steady_clock::time_point started = std::chrono::steady_clock::now();
  };

  LocalWorkers(std::filesystem::path program, std::uint32_t domain) : program_(std::move(program)), domain_(domain) {}
  Result<pid_t> spawn(const Flags& flags) const;

  std::filesystem::path program_;
  std::uint32_t domain_ = 0;
  std::vector<Worker> workers_;
};

// coppice-worker beside the running program, else in the directories of PATH. Errors say where it was looked for.
Result<std::filesystem::path> find_worker_program();

}  // namespace coppice
