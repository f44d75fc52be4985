// Worker processes of this coordinator on this machine: started, in the place of one that ended too, and reaped.
// Whether one is started again is for the dispatcher to say. Each is in a process group of its own, so that Ctrl-C
// reaches the coordinator alone, and dies with the coordinator even when that is killed. One thread uses it.
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
  static constexpr std::size_t kMaxWorkers = 1024;

  // Starts workers of `program` for the coordinator of this machine in `domain`: one for each list of flags, which it
  // gets beside those that bring it here. Each evaluates with so many threads; if all threads together are as many as
  // the cores, each has a core of its own (common/cores.hpp).
  // REQUIRES: the calling thread lives as long as the workers: they die with it. Errors: the program cannot be
  // started (those that were are stopped).
  using Flags = std::vector<std::string>;
  static Result<LocalWorkers> start(const std::filesystem::path& program, const std::vector<Flags>& flags,
                                    std::uint32_t domain, std::uint32_t threads = 1);
  static Result<LocalWorkers> start(const std::filesystem::path& program, std::size_t count, std::uint32_t domain) {
    return start(program, std::vector<Flags>(count), domain);
  }
  // Errors: there is nothing that could be started.
  static Result<void> check(const std::filesystem::path& program);

  LocalWorkers(LocalWorkers&& other) noexcept;
  LocalWorkers& operator=(LocalWorkers&&) = delete;
  LocalWorkers(const LocalWorkers&) = delete;
  LocalWorkers& operator=(const LocalWorkers&) = delete;
  // SIGTERM to all, 1.5 s later SIGKILL to those still there; reaps every one.
  ~LocalWorkers();

  // Reaps workers that ended. Never blocks.
  struct Ended {
    std::size_t place = 0;  // in the order of starting
    pid_t pid = 0;
    bool in_order = false;  // it left: exit code 0
    std::string how;        // a line for the log
  };
  std::vector<Ended> reap();
  // Another one in the place of one that was reaped, with the same flags. Errors: it cannot be started.
  Result<pid_t> start_again(std::size_t place);

  // Whether this worker runs on that core, as one of those that were given cores of their own.
  bool keeps_to(pid_t worker, int core) const;
  // Those that run.
  std::vector<pid_t> pids() const;
  std::size_t running() const { return pids().size(); }

 private:
  struct Worker {
    pid_t pid = 0;  // 0: ended
    Flags flags;
    std::vector<int> cores = {};  // empty: wherever the system likes
  };

  LocalWorkers(std::filesystem::path program, std::uint32_t domain, std::uint32_t threads)
      : program_(std::move(program)), domain_(domain), threads_(threads) {}
  Result<pid_t> spawn(const Worker& worker) const;

  std::filesystem::path program_;
  std::uint32_t domain_ = 0;
  std::uint32_t threads_ = 1;
  std::vector<Worker> workers_;
};

// coppice-worker beside the running program, else in the directories of PATH. Errors say where it was looked for.
Result<std::filesystem::path> find_worker_program();

}  // namespace coppice
