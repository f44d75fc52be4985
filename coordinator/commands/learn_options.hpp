// What `coppice learn` and `coppice run` share: the flags of learning, and learning itself with its progress line.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "common/error.hpp"
#include "common/stop.hpp"
#include "coordinator/learning/learn.hpp"
#include "coordinator/learning/world.hpp"
#include "coordinator/study/study.hpp"

namespace CLI {
class App;
}

namespace coppice {

// What the user gave; the rest is default_settings() of the world.
struct LearnOptions {
  std::string world = "uav";
  std::string algorithm = "q-learning";
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

struct LearnTask {
  std::string world_name;  // as the user gave it
  World world;
  LearnSettings settings;
};

// Errors name the flag, or the room's file, line and column.
Result<LearnTask> learn_task(const LearnOptions& options, std::uint64_t seed);

// Learns, shows progress on standard error, and makes the study file `path`. Errors: as learn() and Study::create();
// the path exists already, which is found out before learning.
struct LearnReport {
  Study study;
  std::string text;  // lines
  std::string json;  // one object on one line
};
Result<LearnReport> learn_study(const LearnTask& task, const std::string& path, const StopFlag& stop);

// The episode length that the study was learned with; that of thesis Table II where it does not say.
std::uint32_t learned_steps(const Study& study);

}  // namespace coppice
