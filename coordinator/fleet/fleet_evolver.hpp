// Runs epochs of demes on the workers of a Fleet; on the thread of that Fleet.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "common/stop.hpp"
#include "coordinator/dispatch/deme_evolver.hpp"
#include "coordinator/fleet/epoch_work.hpp"
#include "coordinator/fleet/fleet.hpp"

namespace coppice {

class FleetEvolver : public DemeEvolver {
 public:
  // `fleet` and `stop` outlive it.
  FleetEvolver(Fleet& fleet, std::shared_ptr<const Chain> chain, const StopFlag& stop);

  // Whether every epoch of such demes fits into the messages of the contract.
  static bool fits(const Chain& chain, const EvolveConfig& config);

  void submit(std::uint64_t ticket, std::shared_ptr<const EvolveConfig> config, EpochTask task) override;
  Result<Finished> next() override;
  // The same without waiting and without bringing anything forward: for who drives the fleet himself.
  std::optional<Finished> take_ended();
  // What was submitted is forgotten; for after a failure of the fleet, which ends all requests.
  void forget() { tickets_.clear(); }

 private:
  using Bytes = std::shared_ptr<const std::vector<std::uint8_t>>;
  const Bytes& packed(const std::shared_ptr<const EvolveConfig>& config, bool begins);

  Fleet& fleet_;
  std::shared_ptr<const Chain> chain_;
  const StopFlag& stop_;
  wire::EpochDecoder decoder_;
  EpochRunner runner_;  // to check others
  std::map<RequestId, std::uint64_t> tickets_;
  std::shared_ptr<const EvolveConfig> config_;  // that was packed last
  Bytes begins_;
  Bytes goes_on_;
};

}  // namespace coppice
