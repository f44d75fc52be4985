// Worker processes of this coordinator on this machine: started, watched, replaced when they die, and reaped. Each is
// in a process group of its own, so that Ctrl-C reaches the coordinator alone, and dies with the coordinator even when
// that is killed. One thread uses it.
#pragma once

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
  static constexpr int kMaxRestarts = 3;  // of each worker
  static constexpr std::size_t kMaxWorkers = 1024;

  // Starts `count` workers of `program` for the coordinator of this machine in `domain`. Errors: the program cannot be
  // started (those that were are stopped).
  static Result<LocalWorkers> start(const std::filesystem::path& program, std::size_t count, std::uint32_t domain);

  LocalWorkers(LocalWorkers&& other) noexcept;
  LocalWorkers& operator=(LocalWorkers&&) = delete;
  LocalWorkers(const LocalWorkers&) = delete;
  LocalWorkers& operator=(const LocalWorkers&) = delete;
  // SIGTERM to all, a second later SIGKILL to those still there; reaps every one.
  ~LocalWorkers();

  // Reaps workers that ended and starts others in their place, kMaxRestarts times each. Never blocks. Returns what
  // happened, a line each, for the log.
  std::vector<std::string> tend();

  // Those that run.
  std::vector<pid_t> pids() const;
  std::size_t running() const { return pids().size(); }

 private:
  struct Worker {
    pid_t pid = 0;  // 0: given up
    int restarts = 0;
  };

  LocalWorkers(std::filesystem::path program, std::uint32_t domain) : program_(std::move(program)), domain_(domain) {}
  Result<pid_t> spawn() const;

  std::filesystem::path program_;
  std::uint32_t domain_ = 0;
  std::vector<Worker> workers_;
};

// coppice-worker beside the running program, else in the directories of PATH. Errors say where it was looked for.
Result<std::filesystem::path> find_worker_program();

}  // namespace coppice
