// What a coordinator's program does, in Prometheus' text format, wherever it is asked for (common/metrics). Fed by the
// fleet about once a second and by evolution after each generation; safe from any thread. It watches and changes
// nothing: results are the same with and without.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "common/error.hpp"
#include "common/evolution/champion.hpp"
#include "common/metrics/outlet.hpp"
#include "coordinator/metrics/fleet_status.hpp"

namespace coppice {

class RunMetrics {
 public:
  // Errors: as MetricsOutlet::open().
  static Result<std::shared_ptr<RunMetrics>> open(const MetricsTargets& targets);

  void fleet(const FleetStatus& status);
  // What an evaluator did, fleet or none.
  void statistics(const DispatchStatistics& statistics);
  // `run`: how it is called. One that ended stays as it was last, unless it is forgotten: many would be too many.
  void run_started(const std::string& run, std::uint32_t generations, std::uint32_t begin);
  void generation_done(const std::string& run, const GenerationRecord& record);
  void forget(const std::string& run);
  // Of a sweep.
  void runs(std::size_t ended, std::size_t all);

  std::string text() const;
  std::uint16_t port() const { return outlet_ == nullptr ? std::uint16_t{0} : outlet_->port(); }

 private:
  struct Run {
    std::uint32_t generations = 0;
    std::uint32_t done = 0;
    std::uint64_t evaluations = 0;
    std::optional<GenerationRecord> last;
    double best = 0.0;
    std::uint32_t rollbacks = 0;
  };

  RunMetrics() = default;

  mutable std::mutex mutex_;
  FleetStatus fleet_;
  bool has_fleet_ = false;
  std::map<std::string, Run> runs_;
  std::size_t runs_ended_ = 0;
  std::size_t runs_all_ = 0;
  std::unique_ptr<MetricsOutlet> outlet_;  // last: its threads read what is above
};

}  // namespace coppice
