#include "coordinator/fleet/fleet_evaluator.hpp"

#include "common/wire/short_turns.hpp"

namespace coppice {

Result<std::unique_ptr<FleetEvaluator>> FleetEvaluator::open(std::shared_ptr<const Chain> chain, FleetOptions options,
                                                             const StopFlag& stop) {
  auto fleet = Fleet::open(chain, std::move(options), stop);
  if (!fleet) {
    return tl::unexpected(fleet.error());
  }
  return std::unique_ptr<FleetEvaluator>(new FleetEvaluator(std::move(*fleet), std::move(chain), stop));
}

DemeEvolver* FleetEvaluator::demes(const EvolveConfig& config) {
  if (!FleetEvolver::fits(*chain_, config)) {
    return nullptr;
  }
  if (!demes_) {
    demes_.emplace(*fleet_, chain_, stop_);
  }
  return &*demes_;
}

DispatchStatistics FleetEvaluator::statistics() const { return fleet_->statistics(); }

Result<std::vector<Tally>> FleetEvaluator::evaluate(std::span<const Tree> trees, const Job& job) {
  auto at_home = fleet_->evaluate_at_home(trees, job);
  if (!at_home) {
    return tl::unexpected(at_home.error());
  }
  if (*at_home) {
    return std::move(**at_home);
  }
  const wire::ShortTurns turns;
  const bool somebody_is_there = fleet_->ready_lanes() > 0;  // else it is their coming that takes long
  const auto begin = std::chrono::steady_clock::now();
  const auto request = fleet_->submit(trees, job);
  if (!request) {
    return tl::unexpected(request.error());
  }
  while (!fleet_->done(*request)) {
    if (auto ok = fleet_->act(); !ok) {
      fleet_->abandon();
      return tl::unexpected(ok.error());
    }
    if (!fleet_->done(*request)) {
      fleet_->sleep();
    }
  }
  auto tallies = fleet_->take_tallies(*request).tallies;
  if (somebody_is_there) {
    fleet_->took_workers(trees.size(), job, std::chrono::steady_clock::now() - begin);
  }
  return tallies;
}

}  // namespace coppice
