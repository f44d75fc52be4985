// The seam of the coordinator: a batch of trees in, their tallies out, in order; or epochs of demes (deme_evolver.hpp).
// Serial and remote evaluation are indistinguishable but for time: the same bits for any number of workers and any
// fault.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "common/error.hpp"
#include "common/fitness/job.hpp"
#include "common/tree/tree.hpp"

namespace coppice {

struct EvolveConfig;
class DemeEvolver;

// What an evaluator did so far; for progress lines and reports, never for decisions. Units of work are individuals, but
// for other kinds of work (work.hpp).
struct DispatchStatistics {
  std::uint64_t individuals = 0;     // settled
  std::uint64_t repeated = 0;        // of them: not evaluated, because another meant the same
  std::uint64_t batches = 0;         // sent
  std::uint64_t copies = 0;          // of them, copies of what was late
  std::uint64_t sent_bytes = 0;      // of tasks: what the batches' payloads hold
  std::uint64_t received_bytes = 0;  // of answers
  std::uint64_t duplicates = 0;      // answers to batches that were already settled
  std::uint64_t compared = 0;        // individuals in them that were compared with what had settled them
  std::uint64_t requeued = 0;        // batches taken back from a worker that died, hung, left or was late
  std::uint64_t retried = 0;         // individuals in them that were handed out again
  std::uint64_t suspect = 0;         // of them: their worker's process died while it was at them
  std::uint64_t apart = 0;           // individuals that the coordinator evaluated in a process of its own, therefore
  std::uint64_t at_home = 0;         // individuals that it evaluated itself, because sending them costs more
  std::uint64_t rejected = 0;        // samples that did not decode, or belonged to nobody
  std::uint64_t workers_lost = 0;
  std::uint64_t cross_checked = 0;  // individuals that the coordinator evaluated again
  std::uint64_t quarantined = 0;    // workers that answered wrongly
  std::uint64_t refused = 0;        // workers of another protocol, or whose build computes otherwise
  std::uint64_t busy_ns = 0;        // that workers' lanes worked for answers which were heard, as they say
  std::size_t workers_alive = 0;
  // At this moment: epochs that run or wait, and how many the workers hold, from the one with fewest to the one with
  // most, copies included.
  std::size_t epochs_open = 0;
  std::size_t fewest_held = 0;
  std::size_t most_held = 0;
};

class Evaluator {
 public:
  Evaluator() = default;
  Evaluator(const Evaluator&) = delete;
  Evaluator& operator=(const Evaluator&) = delete;
  virtual ~Evaluator() = default;

  // One tally per tree, in the order of the trees: never another than the pure function's. REQUIRES: every tree passed
  // check_tree() for the chain. Errors: interrupted (the stop flag was raised); failed (no worker within the limit; a
  // tree that ends every process that evaluates it, which is named); revoked (what was returned earlier rests on a
  // worker that is now found to lie: whoever built on it may begin again); bad_input (the job does not fit the chain).
  virtual Result<std::vector<Tally>> evaluate(std::span<const Tree> trees, const Job& job) = 0;

  // Whoever runs epochs of such demes where this evaluates; null: they are bred by the caller, and their slots
  // evaluated. Lives as long as the evaluator, and is not used while evaluate() is.
  virtual DemeEvolver* demes(const EvolveConfig& config) {
    static_cast<void>(config);
    return nullptr;
  }

  virtual DispatchStatistics statistics() const = 0;
};

}  // namespace coppice
