// One set of workers shared by several runs at a time, each on a thread of its own: while one run waits for the last
// answers of its generation, the workers are busy with the others'. A thread of the pool dispatches for all of them;
// what is sooner evaluated than sent a run evaluates on its own thread, if the options allow it (may_stay_home).
// The pool decides time only: every run gets the tallies that it would get alone.
#pragma once

#include <atomic>
#include <condition_variable>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "common/fitness/prepared_chain.hpp"
#include "coordinator/dispatch/deme_evolver.hpp"
#include "coordinator/fleet/fleet.hpp"
#include "coordinator/fleet/fleet_evolver.hpp"

namespace coppice {

class EvaluatorPool {
 public:
  // `stop` outlives the pool. Errors: Fleet::open().
  static Result<std::unique_ptr<EvaluatorPool>> open(std::shared_ptr<const Chain> chain, FleetOptions options,
                                                     const StopFlag& stop);
  ~EvaluatorPool();
  EvaluatorPool(const EvaluatorPool&) = delete;
  EvaluatorPool& operator=(const EvaluatorPool&) = delete;

  // For one thread; the pool outlives it. Its statistics are those of its own requests, without the traffic.
  std::unique_ptr<Evaluator> client();
  // Of all. Safe from any thread.
  DispatchStatistics statistics() const;

 private:
  class Client;
  // An epoch of a client's, from submit() until it is in the client's hands.
  struct Epoch {
    Client* client = nullptr;  // null: nobody waits any more
    std::uint64_t ticket = 0;  // the client's
    std::shared_ptr<const EvolveConfig> config;
    EpochTask task;
  };
  // One evaluate() of a client, which waits for it.
  struct Call {
    std::span<const Tree> trees;
    const Job* job = nullptr;
    std::optional<Result<Fleet::Evaluated>> result;
    std::condition_variable answered;  // its own: one shared by all would wake every run for every answer
  };

  EvaluatorPool(std::unique_ptr<Fleet> fleet, std::shared_ptr<const Chain> chain, bool may_stay_home,
                const StopFlag& stop);

  Result<Fleet::Evaluated> evaluate(std::span<const Tree> trees, const Job& job);
  void submit(Epoch epoch);
  Result<DemeEvolver::Finished> next(Client& client);
  void forget(const Client& client);
  void took_home(std::uint64_t individuals, std::uint64_t repeated);
  static void answer(Call& call, Result<Fleet::Evaluated> result);  // REQUIRES: mutex_ is held
  void run();
  void take_calls();
  void answer_calls();
  void fail_calls(const Error& error);

  const std::shared_ptr<const Chain> chain_;
  std::unique_ptr<Fleet> fleet_;     // of the pool's thread
  FleetEvolver evolver_;             // likewise
  std::map<RequestId, Call*> open_;  // likewise
  const StopFlag& stop_;
  const std::shared_ptr<const PreparedChain> home_chain_;  // null: nothing is evaluated at home
  std::atomic<std::size_t> ready_lanes_{0};

  mutable std::mutex mutex_;  // what follows
  std::deque<Call*> calls_;
  std::deque<Epoch> epochs_;                       // submitted
  std::map<std::uint64_t, Epoch> running_epochs_;  // by the pool's ticket, without their tasks
  std::uint64_t next_ticket_ = 0;
  std::condition_variable epoch_ended_;
  DispatchStatistics statistics_;  // of the fleet
  DispatchStatistics at_home_;     // of the runs' own threads
  std::optional<Error> broken_;    // nothing is evaluated any more
  bool ending_ = false;

  std::thread thread_;
};

}  // namespace coppice
