// The flags that set up an evolution, as several commands have them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/error.hpp"
#include "common/evolution/config.hpp"
#include "common/tree/vocabulary.hpp"

namespace CLI {
class App;
}

namespace coppice {

struct EvolveOptions {
  std::string config_file;
  std::vector<std::string> settings;  // "ga.population=200"
  std::string prefer;                 // front.prefer; empty: as configured
  std::string pick;                   // front.pick, which then decides; empty: as configured
  std::uint32_t lines_every = 0;      // generations between plain progress lines; 0: only by time
};

// All flags but --seed, which a command may share with learning, and those of the evaluator.
void add_evolve_options(CLI::App& command, EvolveOptions& options);

// What an evolution is set up for, beside the flags.
struct EvolveSubject {
  const Vocabulary& vocabulary;
  std::optional<double> discount = std::nullopt;  // that its Q-values were solved with
  bool simulated = true;                          // there is a simulator to try trees in
  const EvolveConfig* base = nullptr;             // of a run that is carried on; stands for the default recipe
};

// The recipe or file of --config, which is changed by the assignments, then the seed, if given, then by who is to
// choose the answer. Without --config it is `base`; without that the recipe is `best`, or `return` for a model that was
// solved and has no simulator. A file's keys that it leaves out are those of the thesis; a discount that nothing names
// is the subject's. Errors name file and line, or the assignment.
Result<EvolveConfig> evolve_config(const EvolveOptions& options, std::optional<std::uint64_t> seed,
                                   const EvolveSubject& subject);

}  // namespace coppice
