// What a sweep runs: every combination of the grid's values (a setting) with every seed. Read from a TOML file:
//
//   config = "base.toml"        # what all runs start from; left out: the defaults, thesis Table III
//   seeds = 10                  # runs per setting, with seeds 1 to 10; or a list of seeds
//   episodes = 500              # in the simulator, for every answer; 0: none
//
//   [set]                       # the same in all runs, after `config`
//   ga.generations = 150
//
//   [grid]                      # a list for each key
//   ga.population = [50, 100]
//   rollout.acting = ["tree", "policy"]
//
// Settings are in the order of the grid's keys, which is alphabetical, the last changing fastest.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/error.hpp"
#include "common/evolution/config.hpp"
#include "common/tree/vocabulary.hpp"

namespace coppice {

inline constexpr std::size_t kMaxSweepRuns = 1'000'000;

struct SweepSetting {
  std::vector<std::string> values;  // one for each of SweepPlan::keys, as text
  EvolveConfig config;              // but for the seed
};

struct SweepRun {
  std::size_t setting = 0;
  EvolveConfig config;  // with its seed
};

struct SweepPlan {
  std::vector<std::string> keys;  // "ga.population"
  std::vector<SweepSetting> settings;
  std::vector<std::uint64_t> seeds;
  std::uint64_t episodes = 500;

  // By setting, then by seed.
  std::vector<SweepRun> runs() const;
  // "ga.population=50 rollout.acting=tree"; "as configured" where there is no grid.
  std::string label(std::size_t setting) const;
};

// Errors name file and line, what was found and what was expected; a setting that is wrong as a whole is named by its
// label.
Result<SweepPlan> load_sweep(const std::string& path, const Vocabulary& vocabulary);
// The same for text that is already read; `name` stands for the file in messages, and for the folder that `config` is
// looked for in.
Result<SweepPlan> read_sweep(std::string_view toml, const std::string& name, const Vocabulary& vocabulary);

}  // namespace coppice
