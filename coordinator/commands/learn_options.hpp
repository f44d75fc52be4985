// The flags of learning, as `coppice learn` and `coppice run` have them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "common/error.hpp"
#include "common/stop.hpp"
#include "coordinator/runs/learn_study.hpp"

namespace CLI {
class App;
}

namespace coppice {

// What the user gave; the rest is default_settings() of the world.
struct LearnOptions {
  std::string world = "uav";
  std::string algorithm;  // empty: that of the world
  std::optional<std::uint64_t> episodes;
  std::uint64_t greedy_episodes = 0;
  std::optional<std::uint32_t> steps;
  std::optional<double> alpha;
  std::optional<double> gamma;
  std::optional<double> epsilon;
  std::optional<std::string> decay;
};

// All flags but --seed, which a command may share with evolution.
void add_learn_options(CLI::App& command, LearnOptions& options);

// Errors name the flag, or the room's file, line and column.
Result<LearnTask> learn_task(const LearnOptions& options, std::uint64_t seed);

// learn_study() with its progress on standard error.
Result<LearnReport> learn_shown(const LearnTask& task, const std::string& path, const StopFlag& stop,
                                const LearnCheckpoint& resumed = {});

}  // namespace coppice
