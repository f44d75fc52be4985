// Brings evaluations to worker processes over DDS and their tallies back. It listens (hellos, requests for the chain,
// answers), keeps the books (InFlight) and the workers (RemoteFleet), and hands out batches of every request that is
// open: events are collected, then acted on, by whichever thread calls act() and sleep(). Whatever the workers do (die,
// hang, leave, answer twice, join late) the tallies are those of the serial evaluator.
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
#include "common/stop.hpp"
#include "coordinator/dispatch/cross_check.hpp"
#include "coordinator/dispatch/evaluator.hpp"
#include "coordinator/dispatch/in_flight.hpp"
#include "coordinator/dispatch/local_workers.hpp"
#include "coordinator/dispatch/remote_endpoints.hpp"
#include "coordinator/dispatch/remote_fleet.hpp"
#include "coordinator/dispatch/remote_request.hpp"
#include "coordinator/dispatch/remote_worker.hpp"

namespace coppice {

struct RemoteOptions {
  std::optional<std::uint32_t> domain;  // a free one if not given
  std::string interface = "lo";         // by name or address
  wire::Network network;
  std::size_t local_workers = 0;                  // to start on this machine; 0: wait for others
  std::filesystem::path worker_program;           // for them
  std::vector<LocalWorkers::Flags> worker_flags;  // more for the first of them
  std::chrono::milliseconds wait_limit{600'000};  // without any worker for this long, evaluation fails
  double cross_check = 0.0;                       // share of all individuals, see CrossCheck
  InFlightLimits limits;
  // Called on the dispatching thread when an evaluation is about to fail because earlier ones returned what a worker
  // said that is now found to lie, and nobody had checked. It is gone: who built on that may begin again. May be empty.
  std::function<void()> taken_back;
  // Called on the dispatching thread after each batch went out, with the process that got it. May be empty.
  std::function<void(pid_t)> batch_sent;
};

enum class RequestId : std::uint64_t {};

class RemoteDispatch {
 public:
  // `stop` outlives it. Errors: no such interface; the domain is taken (or all are); workers that do not start.
  static Result<std::unique_ptr<RemoteDispatch>> open(std::shared_ptr<const Chain> chain, RemoteOptions options,
                                                      const StopFlag& stop);
  ~RemoteDispatch();
  RemoteDispatch(const RemoteDispatch&) = delete;
  RemoteDispatch& operator=(const RemoteDispatch&) = delete;

  // Begins an evaluation; act() and sleep() bring it forward. The trees outlive the request. Errors: the job does not
  // fit the chain.
  Result<RequestId> submit(std::span<const Tree> trees, const Job& job);
  bool done(RequestId id) const;
  struct Finished {
    std::vector<Tally> tallies;  // in the order of the trees
    std::uint64_t repeated = 0;  // DispatchStatistics
  };
  // Ends a request. REQUIRES: done(id).
  Finished take(RequestId id);
  // Ends all requests.
  void abandon();

  // Takes in what happened and does what follows from it. Errors (interrupted, no worker within the limit, what was
  // taken from a worker earlier is taken back) leave the requests open.
  Result<void> act();
  // Until something happens, wake() is called, or it is time to look.
  void sleep();
  void wake() const { dds_.waiter.wake(); }

  DispatchStatistics statistics() const;
  std::uint32_t domain() const { return dds_.domain; }
  // Processes that hold the chain and take batches.
  std::vector<pid_t> ready_pids() const { return fleet_.ready_pids(); }
  // Waits until so many are ready, however long that takes; for measurements, evaluation needs no more than one.
  // Errors: interrupted; nobody came, or nobody can.
  Result<void> await_workers(std::size_t count);

 private:
  using Clock = std::chrono::steady_clock;

  RemoteDispatch(std::shared_ptr<const Chain> chain, RemoteOptions options, const StopFlag& stop,
                 RemoteEndpoints endpoints);

  Result<void> announce();
  Result<void> check_objectives(const Job& job);
  bool worth_seeking_repeats(const Job& job) const;
  void see_portions();

  void listen();
  void take(const wire::ChainRequest& request);
  void take(const wire::Answer& answer);
  void settle(const wire::Answer& answer);
  bool agrees(WorkerId from, const std::vector<Tally>& tallies, const RemoteRequest& request, std::uint32_t first);
  void quarantine(WorkerId from);
  bool is_ours(std::uint32_t protocol, std::uint64_t run_id, const coppice_wire_ChainId& chain) const;

  Result<void> tend(Clock::time_point now);
  void give_up(const std::vector<Slot>& slots);

  void hand_out(Clock::time_point now);
  bool send(RemoteWorker& worker, const Batch& batch);

  // What a generation of the books holds: of this request, from this place on.
  struct Portion {
    RequestId request{};
    std::uint32_t first = 0;
  };
  struct Open {
    RemoteRequest request;
    std::vector<GenerationId> portions;
  };
  const Portion& portion_of(const Batch& batch) const { return portions_.at(batch.generation); }
  void close(std::map<RequestId, Open>::iterator open);

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
  Meanings meanings_;
  CrossCheck cross_check_;
  std::optional<Error> taken_back_;
  std::vector<Objective> checked_objectives_;

  std::map<RequestId, Open> open_;
  std::map<GenerationId, Portion> portions_;
  std::uint64_t next_request_ = 1;
  std::size_t begun_ = 0;           // requests since the paces were last doubted
  Clock::time_point last_settled_;  // or when there was nothing to settle
  Clock::time_point next_tending_;
  bool settling_ = false;         // some worker is new
  bool matching_changed_ = true;  // some worker's readers came or went
};

}  // namespace coppice
