// How a user's wish to stop reaches the code that works: a flag that is raised once and stays raised, and the wake
// callbacks of whoever sleeps and must look at it. StopOnSignals raises one on SIGINT and SIGTERM; signals are blocked
// in every thread and taken by one, so that no signal handler ever runs (and DDS threads never see one).
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <thread>

namespace coppice {

// Safe to use from any thread.
class StopFlag {
 public:
  // Takes its callback back when it is destroyed; after that the callback is neither running nor ever called.
  // REQUIRES: the flag outlives it; not destroyed from inside its own callback.
  class Wake {
   public:
    Wake() = default;
    Wake(Wake&& other) noexcept;
    Wake& operator=(Wake&& other) noexcept;
    Wake(const Wake&) = delete;
    Wake& operator=(const Wake&) = delete;
    ~Wake();

   private:
    friend class StopFlag;
    Wake(const StopFlag& flag, std::uint64_t key) : flag_(&flag), key_(key) {}

    const StopFlag* flag_ = nullptr;
    std::uint64_t key_ = 0;
  };

  StopFlag() = default;
  StopFlag(const StopFlag&) = delete;
  StopFlag& operator=(const StopFlag&) = delete;

  bool raised() const { return raised_.load(std::memory_order_acquire); }

  // Raises the flag and calls every callback once, on this thread. Later calls do nothing.
  void raise();

  // Calls `wake` once when the flag is raised: on the raising thread, or here and now if it is raised already.
  // A callback is short and never calls back into the flag.
  [[nodiscard]] Wake on_raise(std::function<void()> wake) const;

 private:
  std::atomic<bool> raised_{false};
  mutable std::mutex mutex_;
  mutable std::map<std::uint64_t, std::function<void()>> wakes_;
  mutable std::uint64_t next_key_ = 1;
};

// Blocks SIGINT and SIGTERM in this thread and in every thread it starts from now on.
// REQUIRES: no other thread exists yet. Throws std::system_error.
void block_stop_signals();

// One thread that waits for SIGINT and SIGTERM: the first raises the flag, the second ends the process at once with
// exit code 130. REQUIRES: block_stop_signals() was called; `flag` outlives this.
class StopOnSignals {
 public:
  explicit StopOnSignals(StopFlag& flag);
  StopOnSignals(const StopOnSignals&) = delete;
  StopOnSignals& operator=(const StopOnSignals&) = delete;
  ~StopOnSignals();

 private:
  void wait_for_signals(StopFlag& flag) const;

  int signals_;  // signalfd
  int leave_;    // eventfd, written by the destructor
  std::thread thread_;
};

}  // namespace coppice
