// An evolution's progress on standard error: best and mean fitness, sizes, rate, workers.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "coordinator/console/progress.hpp"
#include "coordinator/runs/evolve_in_study.hpp"

namespace coppice {

class EvolveProgress {
 public:
  // A plain line (standard error is no terminal) every `lines_every` generations; 0: every so many seconds only.
  EvolveProgress(EvaluatorChoice::Kind kind, std::uint32_t lines_every) : kind_(kind), lines_every_(lines_every) {}

  // What evolve_in_study() takes. This outlives it.
  EvolveWatch watch();
  // Ends the line.
  void finish(const EvolveReport& report);

 private:
  EvaluatorChoice::Kind kind_;
  std::uint32_t lines_every_;
  std::optional<Progress> progress_;
};

// evolve_in_study() with this progress.
Result<EvolveReport> evolve_shown(Study& study, const EvolveTask& task, std::uint32_t lines_every,
                                  const StopFlag& stop);

}  // namespace coppice
