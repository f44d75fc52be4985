// Where evaluation happens, as a user chooses it, and the evaluator that follows from it.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "common/chain/chain.hpp"
#include "common/error.hpp"
#include "common/stop.hpp"
#include "coordinator/dispatch/evaluator.hpp"
#include "coordinator/fleet/evaluator_pool.hpp"
#include "coordinator/metrics/run_metrics.hpp"

namespace coppice {

struct EvaluatorChoice {
  enum class Kind : std::uint8_t {
    serial,  // on the coordinator's own thread
    local,   // worker processes that it starts on this machine
    remote,  // workers that were started by hand, here or on other hosts
  };
  Kind kind = Kind::local;
  std::size_t threads = 1;               // serial: that demes are spread over
  std::size_t workers = 1;               // local: how many
  std::filesystem::path worker_program;  // local: empty: find_worker_program()
  std::optional<std::uint32_t> domain;   // DDS domain; local: a free one if not given; remote: 0
  std::string interface = "lo";          // remote: the network interface to listen on, by name or address
  std::string advertise;                 // remote: see wire::Network; empty: its own address
  std::filesystem::path security;        // remote: folder of an identity under DDS Security; empty: none
  bool lossy = false;                    // remote: small packets, quick repair
  double cross_check = 0.0;              // share of all individuals that is evaluated here again
  std::shared_ptr<RunMetrics> metrics;   // is told what happens; may be null
  std::chrono::seconds wait_limit{600};  // without any worker for this long, evaluation fails
  WatchWorkers watch_workers = {};       // not serial: hears of the workers; may be empty
};

// "serial", "2 local workers", "remote workers": kept with a run.
std::string in_words(const EvaluatorChoice& choice);

// For those who work long before they open: finds out what open_evaluator() would refuse about the choice itself.
Result<void> check_choice(const EvaluatorChoice& choice);

// `stop` outlives the evaluator. Errors name the flag: no such interface, a domain that is taken, no worker program.
Result<std::unique_ptr<Evaluator>> open_evaluator(std::shared_ptr<const Chain> chain, const EvaluatorChoice& choice,
                                                  const StopFlag& stop);

// The same for several runs at a time. REQUIRES: not serial.
Result<std::unique_ptr<EvaluatorPool>> open_pool(std::shared_ptr<const Chain> chain, const EvaluatorChoice& choice,
                                                 const StopFlag& stop);

}  // namespace coppice
