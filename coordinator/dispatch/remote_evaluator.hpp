// Evaluates on worker processes over DDS. It listens (hellos, requests for the chain, answers), keeps the books
// (InFlight), and hands out batches, one event loop on the caller's thread: events are collected, then acted on.
// Whatever the workers do (die, hang, leave, answer twice, join late) the tallies are those of the serial evaluator.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <sys/types.h>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/stop.hpp"
#include "common/wire/participant.hpp"
#include "common/wire/topics.hpp"
#include "common/wire/waiter.hpp"
#include "coordinator/dispatch/evaluator.hpp"
#include "coordinator/dispatch/in_flight.hpp"
#include "coordinator/dispatch/local_workers.hpp"
#include "coordinator/dispatch/remote_worker.hpp"

namespace coppice {

struct RemoteOptions {
  std::optional<std::uint32_t> domain;            // a free one if not given
  std::string interface = "lo";                   // by name or address
  std::size_t local_workers = 0;                  // to start on this machine; 0: wait for others
  std::filesystem::path worker_program;           // for them
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

  std::uint32_t domain() const { return domain_; }
  // Processes that hold the chain and take batches.
  std::vector<pid_t> ready_pids() const;

 private:
  using Clock = std::chrono::steady_clock;

  // Everything DDS, made before the evaluator.
  struct Endpoints;
  RemoteEvaluator(std::shared_ptr<const Chain> chain, RemoteOptions options, const StopFlag& stop, std::uint32_t domain,
                  Endpoints endpoints);

  Result<void> announce();
  Result<void> check_objectives(const Job& job);

  void listen();
  void hear(const wire::Hello& hello, const dds_sample_info_t& info);
  void refuse(const wire::Hello& hello);
  void take(const wire::ChainRequest& request);
  void take(const wire::Answer& answer);
  void settle(const wire::Answer& answer, RemoteWorker* worker);
  void lose(WorkerId worker, const std::string& why, InFlight::Farewell farewell);
  Result<void> tend(Clock::time_point now);
  void lose_hanging(Clock::time_point now);
  void lose_process(pid_t pid);
  void ban(WorkerId worker, const std::string& why);
  bool fits(const std::vector<Tally>& tallies, const Batch& batch) const;
  Result<void> wait_for_worker(Clock::time_point now);
  void hand_out(Clock::time_point now);
  bool send(RemoteWorker& worker, const Batch& batch);
  std::chrono::nanoseconds patience_for(const RemoteWorker& worker, std::uint32_t slots) const;
  std::chrono::nanoseconds time_to_sleep(Clock::time_point now) const;
  bool is_ours(std::uint32_t protocol, std::uint64_t run_id, const coppice_wire_ChainId& chain) const;
  void reject(const std::string& what, std::uint64_t source);

  std::shared_ptr<const Chain> chain_;
  std::vector<std::uint8_t> chain_bytes_;
  RemoteOptions options_;
  const StopFlag& stop_;
  std::uint32_t domain_;
  RunIdentity run_;

  struct Endpoints {
    wire::Participant participant;
    wire::Waiter waiter;
    wire::Reader<wire::Hello> hellos;
    wire::Reader<wire::Answer> answers;
    wire::Reader<wire::ChainRequest> requests;
    wire::Writer<wire::Control> control;
  };
  Endpoints dds_;
  StopFlag::Wake wake_;
  std::map<WorkerId, RemoteWorker> workers_;
  std::set<WorkerId> banned_;              // answered nonsense: not heard any more
  std::set<WorkerId> refused_;             // spoke another protocol: told once
  std::set<std::uint64_t> rejected_from_;  // sources of damaged samples: logged once each
  std::optional<LocalWorkers> local_;

  InFlight flight_;
  std::chrono::seconds hang_limit_;
  Clock::time_point last_settled_;  // or the generation's start
  std::vector<Objective> checked_objectives_;
  std::span<const Tree> trees_;  // of the generation in flight
  Job job_;
  std::uint64_t job_steps_ = 0;  // of every tally that has a result
  std::uint32_t most_per_task_ = 0;
  std::vector<Tally> tallies_;
  std::optional<Clock::time_point> without_worker_since_;
  Clock::time_point next_notice_;
  Clock::time_point next_tending_;
  bool announce_again_ = false;  // somebody does not know of the run
  DispatchStatistics statistics_;
};

}  // namespace coppice
