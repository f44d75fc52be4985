#include "coordinator/fleet/fleet_evolver.hpp"

#include <algorithm>
#include <utility>

#include "common/check.hpp"
#include "common/wire/short_turns.hpp"
#include "common/wire/topics.hpp"

namespace coppice {

FleetEvolver::FleetEvolver(Fleet& fleet, std::shared_ptr<const Chain> chain, const StopFlag& stop)
    : fleet_(fleet), chain_(std::move(chain)), stop_(stop), decoder_(*chain_), runner_(PreparedChain::make(chain_)) {}

bool FleetEvolver::fits(const Chain& chain, const EvolveConfig& config) {
  return wire::most_epoch_bytes(config, EpochCheck(chain, config).objectives()) <= wire::kMaxTaskPayload;
}

const FleetEvolver::Bytes& FleetEvolver::packed(const std::shared_ptr<const EvolveConfig>& config, bool begins) {
  if (config_ != config) {
    config_ = config;
    begins_ = std::make_shared<const std::vector<std::uint8_t>>(wire::encode_configuration(*config, true));
    goes_on_ = std::make_shared<const std::vector<std::uint8_t>>(wire::encode_configuration(*config, false));
  }
  return begins ? begins_ : goes_on_;
}

void FleetEvolver::submit(std::uint64_t ticket, std::shared_ptr<const EvolveConfig> config, EpochTask task) {
  const Bytes& configuration = packed(config, task.deme == nullptr);
  auto work = std::make_unique<EpochWork>(std::move(config), configuration, std::move(task),
                                          EpochWork::Here{decoder_, runner_, stop_});
  tickets_.emplace(fleet_.submit(std::move(work)), ticket);
}

std::optional<DemeEvolver::Finished> FleetEvolver::take_ended() {
  const auto done =
      std::find_if(tickets_.begin(), tickets_.end(), [&](const auto& open) { return fleet_.done(open.first); });
  if (done == tickets_.end()) {
    return std::nullopt;
  }
  const auto [request, ticket] = *done;
  tickets_.erase(done);
  const Fleet::Finished finished = fleet_.take(request);
  Finished ended{ticket, static_cast<const EpochWork&>(*finished.work).result(finished.outcomes.front())};
  std::uint64_t individuals = 0;
  for (const GenerationRecord& record : ended.result.records) {
    individuals += record.evaluations;
  }
  fleet_.took_epoch(individuals);
  return ended;
}

Result<DemeEvolver::Finished> FleetEvolver::next() {
  COPPICE_CHECK(!tickets_.empty());
  const wire::ShortTurns turns;
  while (true) {
    if (auto ended = take_ended()) {
      return std::move(*ended);
    }
    if (auto ok = fleet_.act(); !ok) {
      fleet_.abandon();
      forget();
      return tl::unexpected(ok.error());
    }
    if (std::none_of(tickets_.begin(), tickets_.end(), [&](const auto& open) { return fleet_.done(open.first); })) {
      fleet_.sleep();
    }
  }
}

}  // namespace coppice
