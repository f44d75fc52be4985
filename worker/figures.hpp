// What a worker did and how it does, for those who watch it: kept by its threads, read by the thread that answers.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <string>

#include "common/metrics/outlet.hpp"
#include "worker/service_manager.hpp"

namespace coppice {

// Time that lanes spend at work, summed, up to now also of what has not ended yet. Safe from any thread.
class BusyTime {
 public:
  using Clock = std::chrono::steady_clock;

  void begin();
  void end();
  double seconds() const;
  std::size_t lanes() const;  // at work now

 private:
  void pass(Clock::time_point now) const;

  mutable std::mutex mutex_;
  mutable std::chrono::nanoseconds passed_{0};
  mutable Clock::time_point since_{};
  std::size_t lanes_ = 0;
};

struct WorkerFigures {
  static constexpr std::size_t kOutcomes = 5;  // of the contract (idl/coppice.idl), in its order
  static constexpr std::chrono::seconds kLongestTurn{
      120};  // of the main loop: four times a second, but for a huge chain

  std::atomic<std::uint64_t> individuals{0};
  std::atomic<std::uint64_t> epochs{0};
  std::array<std::atomic<std::uint64_t>, kOutcomes> tasks{};  // by what became of them
  std::atomic<std::uint64_t> task_bytes{0};                   // payloads that came
  std::atomic<std::uint64_t> answer_bytes{0};                 // and went
  std::atomic<std::uint64_t> chain_bytes{0};                  // blocks that came
  std::atomic<std::uint64_t> coordinators{0};                 // served, one after another
  std::atomic<std::uint32_t> lanes{0};
  std::atomic<std::uint32_t> chains{0};  // held
  BusyTime busy;

  ServiceManager manager;  // of the main thread

  // The main loop turns.
  void turn();
  // Alive: it turned lately. Ready: it serves a coordinator.
  Health health() const;
  // In words.
  void serve(const std::string& coordinator);
  void wait_for(const std::string& what);
  bool serves() const { return serves_; }
  bool waits() const { return waits_; }

 private:
  void say(std::string words);

  std::atomic<bool> serves_{false};
  std::atomic<bool> waits_{false};

  std::atomic<std::chrono::steady_clock::rep> turned_{0};
  mutable std::mutex mutex_;
  std::string words_ = "starting";
};

// In Prometheus' text format. `security`: folder of an identity, or empty.
std::string to_metrics(const WorkerFigures& figures, const std::string& version, const std::string& security);

}  // namespace coppice
