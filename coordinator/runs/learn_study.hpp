// A policy learned in one of our own worlds, and the study file that holds it with its chain. Prints nothing.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "common/error.hpp"
#include "common/stop.hpp"
#include "coordinator/learning/learn.hpp"
#include "coordinator/learning/world.hpp"
#include "coordinator/study/study.hpp"

namespace coppice {

struct LearnTask {
  std::string world_name;  // as the user gave it
  World world;
  LearnSettings settings;
};

struct LearnReport {
  Study study;
  std::string summary;  // a few words
  std::string text;     // lines
  std::string json;     // one object on one line
};

// Learns and makes the study file `path`; tells how many episodes are done. What is interrupted is kept beside it, in
// interrupted_learning_path(). `resumed`: goes on with that, and the file goes once the study is there. Errors: as
// learn() and Study::create(); the path exists already, or interrupted learning that nobody resumes, which are found
// out before learning.
Result<LearnReport> learn_study(const LearnTask& task, const std::string& path, const StopFlag& stop,
                                const std::function<void(std::uint64_t episodes)>& episodes_done,
                                const LearnCheckpoint& resumed = {});

// The episode length that the study was learned with; that of thesis Table II where it does not say.
std::uint32_t learned_steps(const Study& study);

}  // namespace coppice
