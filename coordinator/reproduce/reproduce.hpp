// `coppice reproduce thesis`: the experiments of the thesis, run again on our room and the windy grid, each table
// beside the printed one. Everything lands in one folder: the studies with every run, and the tables. The same settings
// give the same tables, serial or over workers.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "common/error.hpp"
#include "common/stop.hpp"
#include "coordinator/fleet/open_evaluator.hpp"
#include "coordinator/reproduce/comparison.hpp"

namespace coppice {

inline constexpr std::uint32_t kMostTrials = 1000;

struct ReproduceSettings {
  std::uint32_t seeds = 10;            // evolutions of each experiment, seeds 1 to this
  std::uint64_t episodes = 1'000'000;  // of learning in the room
  std::uint64_t learning_seed = 1;
  std::uint64_t score_episodes = 500;  // in the simulator
};
// Error: a number out of range, by its flag.
Result<void> check_settings(const ReproduceSettings& settings);

struct ReproduceHooks {
  // A table is finished: to be shown, so that an interruption loses none.
  std::function<void(const Comparison&)> table;
  // `done` of `total` steps, and what is under way.
  std::function<void(std::uint64_t done, std::uint64_t total, const std::string& doing)> progress;
};

// Studies that it makes in the folder.
inline constexpr const char* kRoomStudy = "uav.coppice";
inline constexpr const char* kGridStudy = "windy.coppice";

// Errors: interrupted; as learning, the evaluator and the study. REQUIRES: check_settings(), the folder exists.
Result<std::vector<Comparison>> reproduce_thesis(const ReproduceSettings& settings, const EvaluatorChoice& choice,
                                                 const std::string& choice_name, const std::filesystem::path& folder,
                                                 const StopFlag& stop, const ReproduceHooks& hooks);

}  // namespace coppice
