// One evaluating thread of a worker: takes a task from the worker's partition, evaluates its trees or runs its epoch,
// answers.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <thread>

#include "common/error.hpp"
#include "common/fitness/evaluation.hpp"
#include "common/stop.hpp"
#include "common/wire/codec.hpp"
#include "common/wire/topics.hpp"
#include "common/wire/waiter.hpp"
#include "worker/chain_store.hpp"
#include "worker/epochs.hpp"
#include "worker/figures.hpp"

namespace coppice {

// What all lanes and the main loop of a worker share.
struct WorkerState {
  std::uint64_t worker = 0;  // random identity
  std::uint32_t protocol = 0;
  std::atomic<std::uint64_t> run_id{0};     // of the coordinator served; 0: none
  std::atomic<std::uint64_t> evaluated{0};  // individuals
  std::atomic<bool> leaving{false};
  std::shared_ptr<WorkerFigures> figures = std::make_shared<WorkerFigures>();
  // What an individual takes at least, on average over a batch: it is evaluated, then the lane rests, so that many
  // workers can be tried on few cores. 0: as long as it takes.
  std::chrono::nanoseconds pace{0};
  ChainStore chains;
  std::function<void(std::span<Tally>)> before_answer;  // tests only: see ServeOptions
  std::function<void(EpochResult&)> before_epoch_answer;

  void leave();  // from now on
  void come_back() { leaving = false; }
  // Sleeps. False: leaving, before the time has come.
  bool rest_until(std::chrono::steady_clock::time_point time);

 private:
  std::mutex mutex_;
  std::condition_variable left_;
};

class Lane {
 public:
  // Starts the thread, on `core` if one is given (common/cores.hpp). `state`, `tasks` and `answers` outlive it; both
  // DDS entities may be shared by lanes. Errors: no DDS entity can be made.
  static Result<std::unique_ptr<Lane>> start(WorkerState& state, const wire::Participant& participant,
                                             const wire::Reader<wire::Task>& tasks, wire::Writer<wire::Answer>& answers,
                                             std::optional<int> core);
  ~Lane();
  Lane(const Lane&) = delete;
  Lane& operator=(const Lane&) = delete;

  // To notice state.leaving. Safe from any thread.
  void wake() const { waiter_.wake(); }

  // What became of a task.
  struct Outcome {
    coppice_wire_Outcome kind = coppice_wire_REFUSED;
    std::vector<std::uint8_t> payload = {};
    std::chrono::nanoseconds elapsed{0};  // evaluating
    std::uint64_t repeated = 0;           // trees that meant what another did
  };

 private:
  using Clock = std::chrono::steady_clock;

  Lane(WorkerState& state, wire::Waiter waiter, const wire::Reader<wire::Task>& tasks,
       wire::Writer<wire::Answer>& answers);

  void run();
  void take_one(const wire::Task& task);
  Outcome try_to_work(const wire::Task& task);
  Outcome work(const wire::Task& task);
  Outcome evaluate(const std::shared_ptr<const PreparedChain>& chain, const wire::Task& task);
  Outcome evolve(const std::shared_ptr<const PreparedChain>& chain, const wire::Task& task);
  static Outcome refusal(const Error& error);
  void count(std::size_t individuals);
  bool pass_time(Clock::time_point begin, std::size_t individuals);
  Result<wire::DecodedTask> decode(const std::shared_ptr<const PreparedChain>& chain, const wire::Task& task);
  Result<void> prepare(const std::shared_ptr<const PreparedChain>& chain, const Job& job);

  WorkerState& state_;
  wire::Waiter waiter_;
  const wire::Reader<wire::Task>& tasks_;
  wire::Writer<wire::Answer>& answers_;
  std::shared_ptr<const PreparedChain> decoder_chain_;
  std::optional<wire::TaskDecoder> decoder_;  // for that chain's tasks
  std::shared_ptr<const PreparedJob> job_;    // of the last task: the next one usually has the same
  std::optional<Evaluation> evaluation_;
  std::optional<Epochs> epochs_;  // if any were asked for
  Clock::time_point free_;        // since when it could have begun the next task
  std::thread thread_;
};

// Answers a task without evaluating it: the worker leaves.
void give_back(const WorkerState& state, const wire::Task& task, wire::Writer<wire::Answer>& answers);

}  // namespace coppice
