// What `coppice evolve` and `coppice run` share: the flags that set up an evolution, and one run of it in a study, with
// its progress line, its checkpoints and its end.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/error.hpp"
#include "common/stop.hpp"
#include "coordinator/dispatch/open_evaluator.hpp"
#include "coordinator/evolution/config.hpp"
#include "coordinator/study/study.hpp"

namespace CLI {
class App;
}

namespace coppice {

struct EvolveOptions {
  std::string config_file;
  std::vector<std::string> settings;  // "ga.population=200"
  std::uint32_t lines_every = 10;     // generations between plain progress lines
};

// All flags but --seed, which a command may share with learning, and those of the evaluator.
void add_evolve_options(CLI::App& command, EvolveOptions& options);

// Thesis Table III, changed by the file, then the assignments, then the seed, if given. Errors name file and line,
// or the assignment.
Result<EvolveConfig> evolve_config(const EvolveOptions& options, std::optional<std::uint64_t> seed,
                                   const Vocabulary& vocabulary);

struct EvolveTask {
  EvolveConfig config;           // of a new run
  std::optional<RunId> resumed;  // or: go on with this one, by its own configuration
  bool take_over = false;        // resume even what may still run on another host
  EvaluatorChoice evaluator;
  std::uint32_t lines_every = 10;
};

struct EvolveReport {
  RunId run{};
  Tree tree;
  Tree pruned;
  bool interrupted = false;
  std::string text;  // lines
  std::string json;  // one object on one line
};

// Runs one evolution in `study`: every generation is saved before the next is bred; the end, however it comes,
// is recorded. Shows progress on standard error. An interruption after the first generation is a report with
// `interrupted` set. Errors: as open_evaluator(), evolve() and the study; then the run is marked as failed and can be
// resumed.
Result<EvolveReport> evolve_in_study(Study& study, const EvolveTask& task, const StopFlag& stop);

// How to go on after an interruption: the command to type.
std::string resume_hint(const Study& study);

}  // namespace coppice
