// Evaluates on worker processes over DDS, one generation at a time, and runs demes there: a Fleet on the caller's
// thread.
#pragma once

#include <memory>
#include <optional>

#include "coordinator/dispatch/evaluator.hpp"
#include "coordinator/fleet/fleet.hpp"
#include "coordinator/fleet/fleet_evolver.hpp"

namespace coppice {

class FleetEvaluator : public Evaluator {
 public:
  // `stop` outlives the evaluator. Errors: Fleet::open().
  static Result<std::unique_ptr<FleetEvaluator>> open(std::shared_ptr<const Chain> chain, FleetOptions options,
                                                      const StopFlag& stop);

  Result<std::vector<Tally>> evaluate(std::span<const Tree> trees, const Job& job) override;
  DemeEvolver* demes(const EvolveConfig& config) override;
  DispatchStatistics statistics() const override;

  std::uint32_t domain() const { return fleet_->domain(); }
  std::vector<pid_t> ready_pids() const { return fleet_->ready_pids(); }
  Result<void> await_workers(std::size_t count) { return fleet_->await_workers(count); }

 private:
  FleetEvaluator(std::unique_ptr<Fleet> fleet, std::shared_ptr<const Chain> chain, const StopFlag& stop)
      : fleet_(std::move(fleet)), chain_(std::move(chain)), stop_(stop) {}

  std::unique_ptr<Fleet> fleet_;
  std::shared_ptr<const Chain> chain_;
  const StopFlag& stop_;
  std::optional<FleetEvolver> demes_;  // once there are any
};

}  // namespace coppice
