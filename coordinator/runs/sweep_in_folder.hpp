// A sweep kept in a folder: its runs in runs.jsonl as they end, its tables and plot behind them. Whoever comes back
// with the same plan, or with one that has more runs, goes on. Prints nothing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>

#include "common/error.hpp"
#include "common/stop.hpp"
#include "coordinator/fleet/open_evaluator.hpp"
#include "coordinator/study/study.hpp"
#include "coordinator/sweep/sweep_report.hpp"

namespace coppice {

struct SweepTask {
  SweepPlan plan;
  EvaluatorChoice evaluator;
  std::filesystem::path folder;
  bool resume = false;      // the folder may exist
  std::size_t at_once = 1;  // runs
};

// How far a sweep is.
struct SweepProgress {
  std::uint64_t done = 0;         // generations, of all runs
  std::uint64_t generations = 0;  // in all
  std::size_t ended = 0;          // runs
  std::size_t runs = 0;           // in all
  std::size_t workers = 0;        // alive; serial: 0
};

struct SweepReport {
  SweepResults results;         // [plan.runs()]
  std::uint64_t at_home = 0;    // individuals that went to no worker, because sending them costs more
  std::uint32_t rollbacks = 0;  // times that runs were begun again, because a worker was found to lie
  Result<void> outcome;         // what ended the sweep before its end, if anything did
};

// Runs what the folder does not hold yet and writes settings.csv, runs.csv and sweep.svg. When a worker is found to
// lie, every run that ended in this process is revoked and run again without that worker, at most kMostRollbacks times.
// `progress` is called one at a time, from any thread. Errors, before anything was run: as open_pool(); the folder
// exists and `resume` is not set; the folder holds runs that the plan does not have (bad_input, naming the line);
// files.
Result<SweepReport> sweep_in_folder(const Study& study, const SweepTask& task, const StopFlag& stop,
                                    const std::function<void(const SweepProgress&)>& progress);

}  // namespace coppice
