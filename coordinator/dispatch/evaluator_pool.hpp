// One set of workers shared by several runs at a time, each on a thread of its own: while one run waits for the last
// answers of its generation, the workers are busy with the others'. A thread of the pool dispatches for all of them.
// The pool decides time only: every run gets the tallies that it would get alone.
#pragma once

#include <condition_variable>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "coordinator/dispatch/remote_dispatch.hpp"

namespace coppice {

class EvaluatorPool {
 public:
  // `stop` outlives the pool. Errors: RemoteDispatch::open().
  static Result<std::unique_ptr<EvaluatorPool>> open(std::shared_ptr<const Chain> chain, RemoteOptions options,
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
  // One evaluate() of a client, which waits for it.
  struct Call {
    std::span<const Tree> trees;
    const Job* job = nullptr;
    std::optional<Result<RemoteRequests::Finished>> result;
    std::condition_variable answered;  // its own: one shared by all would wake every run for every answer
  };

  explicit EvaluatorPool(std::unique_ptr<RemoteDispatch> dispatch);

  Result<RemoteRequests::Finished> evaluate(std::span<const Tree> trees, const Job& job);
  static void answer(Call& call, Result<RemoteRequests::Finished> result);  // REQUIRES: mutex_ is held
  void run();
  void take_calls();
  void answer_calls();
  void fail_calls(const Error& error);

  std::unique_ptr<RemoteDispatch> dispatch_;  // of the pool's thread
  std::map<RequestId, Call*> open_;           // likewise

  mutable std::mutex mutex_;  // what follows
  std::deque<Call*> calls_;
  DispatchStatistics statistics_;
  std::optional<Error> broken_;  // nothing is evaluated any more
  bool ending_ = false;

  std::thread thread_;
};

}  // namespace coppice
