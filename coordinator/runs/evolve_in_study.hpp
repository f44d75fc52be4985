// One evolution kept in a study: every generation is saved before the next is bred, and the end, however it comes, is
// recorded. Knows no flags and prints nothing: commands, `coppice run`, refining and the studio call it alike.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "common/error.hpp"
#include "common/evolution/config.hpp"
#include "common/stop.hpp"
#include "coordinator/evolution/evolve.hpp"
#include "coordinator/fleet/open_evaluator.hpp"
#include "coordinator/runs/answer.hpp"
#include "coordinator/study/study.hpp"

namespace coppice {

struct EvolveTask {
  EvolveConfig config;           // of a new run
  std::optional<RunId> resumed;  // or: go on with this one, by its own configuration
  bool take_over = false;        // resume even what may still run on another host
  EvaluatorChoice evaluator;
};

// Told what happens, on the calling thread. Each may be empty.
struct EvolveWatch {
  // The run exists; `begin` of its `generations` were done before.
  std::function<void(RunId run, std::uint32_t generations, std::uint32_t begin)> started;
  // A generation was saved.
  std::function<void(const GenerationRecord&, const DispatchStatistics&)> generation_done;
};

struct EvolveReport {
  RunId run{};
  EvolveConfig config;
  EvaluatorChoice evaluator;
  Evolved evolved;
  Tree pruned{ActionId{0}};  // the answer, simplified on the study's chain
  DispatchStatistics dispatch;
  std::optional<Answer> answer;  // config.front.prefer chose it
  std::uint32_t rollbacks = 0;   // times that the run went back to `begin`, because a worker was found to lie
  std::uint32_t begin = 0;       // generations that an earlier process did
  double seconds = 0.0;

  const Tree& tree() const { return evolved.best.tree; }
  bool interrupted() const { return evolved.interrupted; }
  // Of the first generations, so many may rest on a worker that this process found to lie.
  std::uint32_t suspect_generations() const { return dispatch.quarantined > 0 ? begin : 0; }
};

// Runs one evolution in `study`. An interruption after the first generation is a report with interrupted(). Errors: as
// open_evaluator(), evolve() and the study; then the run is marked as failed and can be resumed.
Result<EvolveReport> evolve_in_study(Study& study, const EvolveTask& task, const StopFlag& stop,
                                     const EvolveWatch& watch);

// How to go on after an interruption: the command to type.
std::string resume_hint(const Study& study);

}  // namespace coppice
