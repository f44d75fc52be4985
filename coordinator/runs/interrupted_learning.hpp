// Learning that was interrupted, kept in a file beside the study that it was to become: a study is complete or absent,
// so it cannot hold it. The file: eight bytes "coplearn", a version, world, settings and state, and a hash of all that.
// Plain values; functions without state.
#pragma once

#include <filesystem>
#include <string>

#include "common/error.hpp"
#include "coordinator/runs/learn_study.hpp"

namespace coppice {

struct InterruptedLearning {
  LearnTask task;
  LearnCheckpoint checkpoint;
};

// Of a study: its path with ".learning" behind it.
std::filesystem::path interrupted_learning_path(const std::string& study);

// Replaces what was there. Errors name the path and the system's reason.
Result<void> write_interrupted_learning(const std::filesystem::path& path, const InterruptedLearning& learning);

// Errors (bad_input) name the path: there is none; it is no such file, of another version, or damaged.
Result<InterruptedLearning> read_interrupted_learning(const std::filesystem::path& path);

}  // namespace coppice
