// One epoch of a deme on its way through the workers: a request of a single unit, whose outcome is the bytes of its
// result.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "common/evolution/epoch.hpp"
#include "common/stop.hpp"
#include "common/wire/epoch_codec.hpp"
#include "coordinator/fleet/request_work.hpp"

namespace coppice {

class EpochWork : public RequestWork {
 public:
  // What epochs on one chain share; it outlives them.
  struct Here {
    wire::EpochDecoder& decoder;
    EpochRunner& runner;
    const StopFlag& stop;
  };

  // `configuration`: as wire::encode_configuration() packs it for such a task.
  EpochWork(std::shared_ptr<const EvolveConfig> config, std::shared_ptr<const std::vector<std::uint8_t>> configuration,
            EpochTask task, const Here& here);

  RequestTerms terms() const override;
  std::uint32_t look_up_portion() override;
  bool all_seen() const override { return seen_; }
  std::vector<std::uint8_t> encode(std::uint32_t first, std::uint32_t count) const override;
  Result<std::vector<UnitOutcome>> decode(std::span<const std::uint8_t> payload, std::uint32_t first,
                                          std::uint32_t count) const override;
  Result<std::vector<UnitOutcome>> compute(std::span<const std::uint32_t> units) override;
  std::string in_words(std::uint32_t unit) const override;

  // What the outcome says. REQUIRES: it is one that decode() or compute() gave.
  EpochResult result(const UnitOutcome& outcome) const;

 private:
  std::shared_ptr<const EvolveConfig> config_;
  std::shared_ptr<const std::vector<std::uint8_t>> configuration_;
  EpochTask task_;
  Here here_;
  bool seen_ = false;
};

}  // namespace coppice
