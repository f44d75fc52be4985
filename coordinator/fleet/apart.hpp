// One unit of work computed in a process of its own, because workers' processes ended while they were at it: whatever
// it does, this program goes on. The process is coppice-worker --apart; it gets the chain and the task through a socket
// and sends the answer back. A thread of this object's own waits for it.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <sys/types.h>
#include <thread>
#include <vector>

#include "common/error.hpp"
#include "coordinator/dispatch/work.hpp"

namespace coppice {

class Apart {
 public:
  struct Task {
    std::filesystem::path program;
    Unit unit;
    WorkKind work = WorkKind::evaluate;
    std::span<const std::uint8_t> chain_bytes;  // outlive the object
    std::vector<std::uint8_t> payload;
  };
  // `ended` is called on its thread when there is something to take. Errors: the program cannot be started.
  static Result<std::unique_ptr<Apart>> start(Task task, std::function<void()> ended);
  // Kills the process if it still runs.
  ~Apart();
  Apart(const Apart&) = delete;
  Apart& operator=(const Apart&) = delete;

  RequestId request() const { return task_.unit.request; }
  std::uint32_t unit() const { return task_.unit.index; }

  struct Ended {
    std::vector<std::uint8_t> answer;
    std::string died;  // not empty: without an answer, in this way
    std::chrono::nanoseconds elapsed{0};
  };
  // Empty: it runs.
  std::optional<Ended> take_ended();

 private:
  Apart(Task task, pid_t pid, int socket) : task_(std::move(task)), pid_(pid), socket_(socket) {}
  void run();

  Task task_;
  pid_t pid_;
  int socket_;
  std::function<void()> on_end_;
  std::mutex mutex_;
  std::optional<Ended> ended_;
  std::thread thread_;
};

}  // namespace coppice
