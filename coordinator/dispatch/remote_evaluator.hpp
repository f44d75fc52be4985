// Evaluates on worker processes over DDS. It listens (hellos, requests for the chain, answers), keeps the books
// (InFlight) and the workers (RemoteFleet), and hands out batches, one event loop on the caller's thread: events are
// collected, then acted on. Whatever the workers do (die, hang, leave, answer twice, join late) the tallies are those
// of the serial evaluator.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <sys/types.h>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/fitness/meaning.hpp"
#include "common/stop.hpp"
#include "coordinator/dispatch/evaluator.hpp"
#include "coordinator/dispatch/in_flight.hpp"
#include "coordinator/dispatch/local_workers.hpp"
#include "coordinator/dispatch/remote_endpoints.hpp"
#include "coordinator/dispatch/remote_fleet.hpp"
#include "coordinator/dispatch/remote_worker.hpp"

namespace coppice {

struct RemoteOptions {
  std::optional<std::uint32_t> domain;            // a free one if not given
  std::string interface = "lo";                   // by name or address
  wire::Network network;
  std::size_t local_workers = 0;                  // to start on this machine; 0: wait for others
  std::filesystem::path worker_program;           // for them
  std::vector<LocalWorkers::Flags> worker_flags;  // more for the first of them
  std::chrono::milliseconds wait_limit{600'000};  // without any worker for this long, evaluate() fails
  InFlightLimits limits;
  // Called on the evaluating thread after each batch went out, with the process that got it. May be empty.
  std::function<void(pid_t)> batch_sent;
};

class RemoteEvaluator : public Evaluator {
 public:
  // `stop` outlives the evaluator. Errors: no such interface; the domain is taken (or all are); workers that do not
  // start.
  static Result<std::unique_ptr<RemoteEvaluator>> open(std::shared_ptr<const Chain> chain, RemoteOptions options,
                                                       const StopFlag& stop);
  ~RemoteEvaluator() override;

  Result<std::vector<Tally>> evaluate(std::span<const Tree> trees, const Job& job) override;
  DispatchStatistics statistics() const override;

  std::uint32_t domain() const { return dds_.domain; }
  // Processes that hold the chain and take batches.
  std::vector<pid_t> ready_pids() const { return fleet_.ready_pids(); }
  // Waits until so many are ready, however long that takes; for measurements, evaluate() needs no more than one.
  // Errors: interrupted; nobody came, or nobody can.
  Result<void> await_workers(std::size_t count);

 private:
  using Clock = std::chrono::steady_clock;

  RemoteEvaluator(std::shared_ptr<const Chain> chain, RemoteOptions options, const StopFlag& stop,
                  RemoteEndpoints endpoints);

  Result<void> announce();
  Result<void> check_objectives(const Job& job);
  Result<void> evaluate_distinct(const Job& job);
  std::uint32_t most_per_task(std::span<const Tree> trees, const Job& job) const;
  Result<void> act();
  void sleep();

  void listen();
  void take(const wire::ChainRequest& request);
  void take(const wire::Answer& answer);
  void settle(const wire::Answer& answer);
  bool fits(const std::vector<Tally>& tallies, const Batch& batch) const;
  bool is_ours(std::uint32_t protocol, std::uint64_t run_id, const coppice_wire_ChainId& chain) const;

  Result<void> tend(Clock::time_point now);
  void give_up(const std::vector<std::uint32_t>& slots);

  void hand_out(Clock::time_point now);
  bool send(RemoteWorker& worker, const Batch& batch);

  std::shared_ptr<const Chain> chain_;
  std::vector<std::uint8_t> chain_bytes_;
  RemoteOptions options_;
  const StopFlag& stop_;
  RunIdentity run_;
  RemoteEndpoints dds_;
  StopFlag::Wake wake_;
  DispatchStatistics statistics_;
  InFlight flight_;
  RemoteFleet fleet_;

  Clock::time_point last_settled_;  // or the generation's start
  std::vector<Objective> checked_objectives_;
  Meanings meanings_;
  std::vector<Tree> trees_;           // of the generation in flight, of each meaning the first
  std::vector<std::uint32_t> slots_;  // their places in the population
  Job job_;
  std::uint64_t job_steps_ = 0;  // of every tally that has a result
  std::uint32_t most_per_task_ = 0;
  std::vector<Tally> tallies_;
  Clock::time_point next_tending_;
  bool settling_ = false;         // some worker is new
  bool matching_changed_ = true;  // some worker's readers came or went
};

}  // namespace coppice
