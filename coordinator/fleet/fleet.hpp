// The dispatcher's body: it turns what happens on DDS and to worker processes into events, takes the dispatcher's steps
// with the time of the clock, and carries out its actions. It decides nothing; README.md draws the picture.
//
// Whatever the workers do (die, hang, leave, answer twice, join late) the outcomes are those computed here.
//
// Belongs to one thread, but for wake().
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <sys/types.h>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/fitness/meaning.hpp"
#include "common/stop.hpp"
#include "common/wire/credentials.hpp"
#include "coordinator/dispatch/dispatcher.hpp"
#include "coordinator/dispatch/evaluator.hpp"
#include "coordinator/fleet/apart.hpp"
#include "coordinator/fleet/endpoints.hpp"
#include "coordinator/fleet/evaluation_work.hpp"
#include "coordinator/fleet/home_evaluation.hpp"
#include "coordinator/fleet/link.hpp"
#include "coordinator/fleet/local_workers.hpp"
#include "coordinator/fleet/onlookers.hpp"
#include "coordinator/fleet/request_work.hpp"
#include "coordinator/metrics/fleet_status.hpp"

namespace coppice {

struct FleetOptions {
  std::optional<std::uint32_t> domain;  // a free one if not given
  std::string interface = "lo";         // by name or address
  wire::Network network;
  std::size_t local_workers = 0;                  // to start on this machine; 0: wait for others
  std::filesystem::path worker_program;           // for them, and to compute apart; empty: find_worker_program()
  std::uint32_t worker_threads = 1;               // of each of them
  std::vector<LocalWorkers::Flags> worker_flags;  // more for the first of them
  std::chrono::milliseconds wait_limit{600'000};  // without any worker for this long, requests fail
  double cross_check = 0.0;                       // share of all units, see CrossCheck
  InFlightLimits limits;
  // Evaluations may be computed here where sending takes longer, see HomeChoice; local workers are then started when
  // something is worth sending.
  bool may_stay_home = false;
  // Called on the dispatching thread, about once a second while it acts. May be empty.
  std::function<void(const FleetStatus&)> watch;
  // Called on the dispatching thread after each batch went out, with the process that got it. May be empty.
  std::function<void(pid_t)> batch_sent;
  WatchWorkers watch_workers;  // may be empty
};

class Fleet {
 public:
  // `stop` outlives it. Errors: no such interface; the domain is taken (or all are); workers that do not start.
  static Result<std::unique_ptr<Fleet>> open(std::shared_ptr<const Chain> chain, FleetOptions options,
                                             const StopFlag& stop);
  ~Fleet();
  Fleet(const Fleet&) = delete;
  Fleet& operator=(const Fleet&) = delete;

  // Evaluates here, if that is sooner done than by workers (HomeChoice). Empty: to be submitted. Errors: as submit()
  // and act().
  Result<std::optional<std::vector<Tally>>> evaluate_at_home(std::span<const Tree> trees, const Job& job);
  // How long such an evaluation took that was submitted, for the next choice.
  void took_workers(std::size_t trees, const Job& job, std::chrono::nanoseconds elapsed);
  // Begins an evaluation; act() and sleep() bring it forward. The trees outlive the request. Errors: the job does not
  // fit the chain.
  Result<RequestId> submit(std::span<const Tree> trees, const Job& job);
  // Begins a request of any kind.
  RequestId submit(std::unique_ptr<RequestWork> work);
  bool done(RequestId id) const;
  struct Finished {
    std::unique_ptr<RequestWork> work;
    std::vector<UnitOutcome> outcomes;  // [units]
    std::uint64_t repeated = 0;         // DispatchStatistics, by workers
  };
  // Ends a request. REQUIRES: done(id).
  Finished take(RequestId id);
  struct Evaluated {
    std::vector<Tally> tallies;  // in the order of the trees
    std::uint64_t repeated = 0;  // DispatchStatistics
  };
  // The same for an evaluation.
  Evaluated take_tallies(RequestId id);
  // An epoch of a deme that was taken, and its individuals: for the statistics.
  void took_epoch(std::uint64_t individuals) {
    ++epochs_;
    statistics_.individuals += individuals;
  }
  // Ends all requests.
  void abandon();

  // Takes in what happened and does what follows from it. Errors (interrupted; no worker within the limit; a unit that
  // ends processes; revoked) leave the requests open.
  Result<void> act();
  // Until something happens, wake() is called, or it is time to look.
  void sleep();
  void wake() const { dds_.waiter.wake(); }

  DispatchStatistics statistics() const;
  FleetStatus status() const;
  // Computing threads of the workers that are ready.
  std::size_t ready_lanes() const { return dispatcher_.ready_lanes(); }
  std::uint32_t domain() const { return dds_.domain; }
  // Processes that hold the chain and take batches.
  std::vector<pid_t> ready_pids() const;
  // Waits until so many are ready, however long that takes; for measurements, evaluation needs no more than one.
  // Errors: interrupted; nobody came, or nobody can.
  Result<void> await_workers(std::size_t count);

 private:
  using Clock = std::chrono::steady_clock;

  Fleet(std::shared_ptr<const Chain> chain, FleetOptions options, const StopFlag& stop, Endpoints endpoints,
        std::unique_ptr<Evaluator> reference);

  Result<void> announce();
  Result<void> start_workers();  // unless they are
  Result<void> check_objectives(const Job& job);
  bool worth_seeking_repeats(const Job& job) const;

  // Events (hearing.cpp).
  void listen();
  void hear(const wire::Hello& hello, const dds_sample_info_t& info);
  void hear(const wire::ChainRequest& request, const dds_sample_info_t& info);
  void hear(const wire::Answer& answer, const dds_sample_info_t& info);
  void decode(const wire::Answer& answer, AnswerHeard& heard) const;
  void look_at_links();
  bool is_ours(std::uint32_t protocol, std::uint64_t run_id, const coppice_wire_ChainId& chain) const;
  void look_up_portions();

  // Actions. Errors: interrupted.
  Result<void> perform(Actions& actions);
  void send_own_core_last(Actions& actions) const;
  Result<void> perform(const OpenLink& action);
  Result<void> perform(const CloseLink& action);
  Result<void> perform(const SendTask& action);
  Result<void> perform(const SendBlocks& action);
  Result<void> perform(const Announce& action);
  Result<void> perform(const Compute& action);
  Result<void> perform(const StartProcess& action);
  Result<void> perform(const Say& action);
  Result<void> compute_apart(const Compute& action);
  Error in_words(const Failure& failure) const;

  std::shared_ptr<const Chain> chain_;
  std::vector<std::uint8_t> chain_bytes_;
  FleetOptions options_;
  const StopFlag& stop_;
  RunIdentity run_;
  Endpoints dds_;
  StopFlag::Wake wake_;
  Dispatcher dispatcher_;
  std::map<WorkerId, Link> links_;
  std::optional<LocalWorkers> local_;
  Onlookers onlookers_;
  Meanings meanings_;
  std::unique_ptr<Evaluator> reference_;
  HomeEvaluation home_;
  Clock::time_point next_listening_at_home_{};
  std::map<RequestId, std::unique_ptr<RequestWork>> works_;
  std::map<ComputeId, std::unique_ptr<Apart>> apart_;
  std::vector<Objective> checked_objectives_;
  DispatchStatistics statistics_;  // of what the dispatcher does not see
  std::uint64_t epochs_ = 0;
  wire::CertificateWatch certificates_;
  Clock::time_point next_watch_{};

  std::vector<DispatchEvent> events_;
  Clock::time_point wake_at_;
  bool settling_ = false;         // some worker's readers are new
  bool matching_changed_ = true;  // some worker's readers came or went
};

}  // namespace coppice
