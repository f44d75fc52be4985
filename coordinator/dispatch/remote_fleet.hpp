// The workers of a coordinator: met by their Hello, and let go when they leave, die, hang, or answer nonsense. It owns
// what is known of each (RemoteWorker) and the processes that the coordinator started itself, and tells the books
// (InFlight) who is there. Invariant: it and the books know the same workers. Belongs to the evaluating thread.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <sys/types.h>
#include <utility>
#include <vector>

#include "coordinator/dispatch/evaluator.hpp"
#include "coordinator/dispatch/in_flight.hpp"
#include "coordinator/dispatch/local_workers.hpp"
#include "coordinator/dispatch/remote_endpoints.hpp"
#include "coordinator/dispatch/remote_worker.hpp"

namespace coppice {

class RemoteFleet {
 public:
  using Clock = std::chrono::steady_clock;

  // All but the run outlive it.
  RemoteFleet(RemoteEndpoints& dds, const RunIdentity& run, InFlight& flight, DispatchStatistics& statistics);

  // These processes are ours: replaced when they end.
  void adopt(LocalWorkers&& local) { local_.emplace(std::move(local)); }
  // Ends our processes.
  void dismiss() { local_.reset(); }

  // A generation begins: nothing hangs yet.
  void begin();

  void hear(const wire::Hello& hello, const dds_sample_info_t& info);
  // Whether what came in this name came from the worker of that name, or from nobody that is known. What came from
  // somebody else is rejected. Without an origin (the writer is gone) nobody can tell: not its own, and nothing is
  // lost, since what a worker that is gone had goes to others.
  bool is_own(std::uint64_t worker, const std::optional<wire::Origin>& origin, const std::string& what);
  // A sample that did not decode or belongs to nobody: counted, logged once for each source.
  void reject(const std::string& what, std::uint64_t source);
  // A worker that answers nonsense would do so again: its Hellos are not heard any more.
  void ban(WorkerId id, const std::string& why);
  bool is_banned(WorkerId id) const { return banned_.count(id) != 0; }

  // Null: not known, or no more.
  RemoteWorker* find(WorkerId id);
  std::map<WorkerId, RemoteWorker>& workers() { return workers_; }
  const std::map<WorkerId, RemoteWorker>& workers() const { return workers_; }
  // Processes that hold the chain and take batches.
  std::vector<pid_t> ready_pids() const;

  // Notices processes of ours that ended, and workers that stand still on work of `steps` an individual.
  void tend(Clock::time_point now, std::uint64_t steps);
  // Logs that nobody is there, now and then. Errors: nobody came within `limit`, or nobody can.
  Result<void> wait_for_worker(Clock::time_point now, std::chrono::milliseconds limit, const std::string& interface);

  // Whether, since the last call, somebody was heard who does not know of the run.
  bool take_stranger() { return std::exchange(stranger_, false); }
  // Slots that were given up since the last call: too many workers were lost with them.
  std::vector<Slot> take_poisonous() { return std::exchange(poisonous_, {}); }

 private:
  void refuse(const wire::Hello& hello);
  void cast_out(const wire::Hello& hello, coppice_wire_Doing why);
  // For those who look on (coppice workers), while there are any.
  void show(Clock::time_point now);
  void meet(const wire::Hello& hello, const std::optional<wire::Origin>& origin);
  void lose(WorkerId worker, const std::string& why, InFlight::Farewell farewell);
  void lose_process(pid_t pid);
  void lose_hanging(Clock::time_point now, std::uint64_t steps);

  RemoteEndpoints& dds_;
  RunIdentity run_;
  InFlight& flight_;
  DispatchStatistics& statistics_;
  std::map<WorkerId, RemoteWorker> workers_;
  std::set<WorkerId> banned_;  // answered nonsense: not heard any more
  // Not served, but shown: spoke another protocol (told once), or answered wrongly.
  struct Outcast {
    wire::WorkerStatus status;
    Clock::time_point heard;
  };
  std::map<WorkerId, Outcast> outcasts_;
  std::set<WorkerId> refused_;  // told once
  Clock::time_point next_show_;
  std::set<std::uint64_t> rejected_from_;  // sources of damaged samples: logged once each
  std::optional<LocalWorkers> local_;
  std::chrono::seconds hang_limit_;
  std::vector<Slot> poisonous_;
  std::optional<Clock::time_point> without_worker_since_;
  Clock::time_point next_notice_;
  bool stranger_ = false;
};

}  // namespace coppice
