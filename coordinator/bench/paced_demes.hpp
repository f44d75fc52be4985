// How well demes fill workers of a declared pace (coppice-worker --pace), many more than there are cores: the time of a
// run's epochs against the ideal, in which every worker is busy to the end, and against what the formula of demes.hpp
// predicts from the first of the teams. Every run ends as the serial one does.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/error.hpp"
#include "common/stop.hpp"
#include "coordinator/bench/measurement.hpp"
#include "coordinator/bench/pacing.hpp"

namespace coppice {

inline constexpr std::uint32_t kPacedDemeSize = 10;
inline constexpr std::uint32_t kPacedEpoch = 5;    // generations
inline constexpr std::uint32_t kPacedEpochs = 20;  // of each deme
inline constexpr std::uint32_t kPacedIndividualsPerEpoch = kPacedDemeSize * kPacedEpoch;

struct PacedDemesRow {
  std::size_t workers = 0;
  std::uint32_t demes = 0;
  std::uint32_t epochs = 0;        // of all demes
  double ideal_seconds = 0.0;      // of all epochs
  Spread seconds;                  // until all epochs had ended; the last comparison aside
  double predicted_seconds = 0.0;  // 0: the first team, or workers of different paces
  double copies = 0.0;             // epochs sent a second time, a run
  double busy = 0.0;               // of a core: the coordinator's process
};

// settings.population / kPacedDemeSize demes; 0: one for each worker; two at least. REQUIRES: slow_workers <= every
// number of workers. Errors: as FleetEvaluator; failed: a run ended otherwise than the serial one.
Result<std::vector<PacedDemesRow>> measure_paced_demes(const std::shared_ptr<const Chain>& chain,
                                                       const PacingSettings& settings, const StopFlag& stop,
                                                       const std::function<void(const PacedDemesRow&)>& done);

}  // namespace coppice
