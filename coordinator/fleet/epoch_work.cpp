#include "coordinator/fleet/epoch_work.hpp"

#include <fmt/format.h>
#include <utility>

#include "common/check.hpp"
#include "common/evolution/migration.hpp"

namespace coppice {

EpochWork::EpochWork(std::shared_ptr<const EvolveConfig> config,
                     std::shared_ptr<const std::vector<std::uint8_t>> configuration, EpochTask task, const Here& here)
    : config_(std::move(config)), configuration_(std::move(configuration)), task_(std::move(task)), here_(here) {}

RequestTerms EpochWork::terms() const {
  const std::uint32_t begin = task_.deme ? task_.deme->generations : 0;
  const std::uint64_t individuals = std::uint64_t{share_of(config_->ga, task_.number).size} * (task_.until - begin);
  return {.work = {WorkKind::evolve, individuals}, .most_per_batch = 1, .expected = 1};
}

std::uint32_t EpochWork::look_up_portion() { return std::exchange(seen_, true) ? 0 : 1; }

std::vector<std::uint8_t> EpochWork::encode(std::uint32_t, std::uint32_t) const {
  return wire::encode_epoch_task(*configuration_, task_);
}

Result<std::vector<UnitOutcome>> EpochWork::decode(std::span<const std::uint8_t> payload, std::uint32_t,
                                                   std::uint32_t) const {
  if (const auto result = here_.decoder.decode_result(payload, config_, task_); !result) {
    return tl::unexpected(result.error());
  }
  return std::vector<UnitOutcome>{std::vector<std::uint8_t>(payload.begin(), payload.end())};
}

Result<std::vector<UnitOutcome>> EpochWork::compute(std::span<const std::uint32_t> units) {
  COPPICE_CHECK(units.size() == 1);
  const auto result = here_.runner.run(*config_, task_, [this](std::size_t) { return !here_.stop.raised(); });
  if (!result) {
    return tl::unexpected(result.error());
  }
  return std::vector<UnitOutcome>{wire::encode_epoch_result(*result)};
}

std::string EpochWork::in_words(std::uint32_t) const {
  return fmt::format("deme {} from generation {} to {} (seed {}); to see it again: the same command with --serial",
                     task_.number, task_.deme ? task_.deme->generations : 0, task_.until, config_->seed);
}

EpochResult EpochWork::result(const UnitOutcome& outcome) const {
  auto result = here_.decoder.decode_result(std::get<std::vector<std::uint8_t>>(outcome), config_, task_);
  COPPICE_CHECK(result.has_value());
  return std::move(*result);
}

}  // namespace coppice
