// A folder of its own for each test, and a study on the small chain in it.
#pragma once

#include <gtest/gtest.h>
#include <optional>
#include <string>
#include <vector>

#include "coordinator/study/study.hpp"
#include "tests/coordinator/evolution/small_world.hpp"
#include "tests/temporary_folder.hpp"

namespace coppice::testing {

class StudyFiles : public ::testing::Test {
 protected:
  Study make();
  Study reopen(Study closed) const;

  static EvolveConfig config();
  static EvolveHooks saving_hooks(Study& study, RunId run);
  // Evolves with a WalkingEvaluator and saves every generation; gives back their records.
  std::vector<GenerationRecord> evolve_into(Study& study, RunId run, const EvolveConfig& config);

  std::string content() const;             // bytes of the study file
  void overwrite(std::string_view bytes);  // of the study file
  std::vector<std::string> files() const;  // names in the folder, sorted

  template <typename T>
  static std::string message(const Result<T>& result) {
    return result ? std::string("(no error)") : result.error().message;
  }

  Chain chain_ = small_chain();
  StudyWorld world_{"uav", "####\n#^.#\n####\n"};
  StudyLearning learning_{R"({"alpha":0.5})", R"({"reward":283.0})"};
  TemporaryFolder temporary_;
  std::string folder_ = temporary_.path().string();
  std::string path_ = temporary_ / "one.study";
};

}  // namespace coppice::testing
