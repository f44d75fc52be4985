// Studies that earlier versions wrote, kept in kept/VERSION.coppice: each must open, whole, in every later version, and
// its unfinished run go on. A release adds its own: a small room, a run, a front, and a run that was interrupted.
#include <algorithm>
#include <filesystem>
#include <gtest/gtest.h>
#include <vector>

#include "coordinator/study/study_check.hpp"
#include "tests/coordinator/study/study_fixture.hpp"

namespace coppice {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> kept_studies() {
  std::vector<fs::path> studies;
  for (const auto& entry : fs::directory_iterator(COPPICE_SOURCE_DIR "/tests/coordinator/study/kept")) {
    if (entry.path().extension() == ".coppice") {  // older schemas: problem_study_test
      studies.push_back(entry.path());
    }
  }
  std::sort(studies.begin(), studies.end());
  return studies;
}

using KeptStudy = testing::StudyFiles;

TEST_F(KeptStudy, OfEveryVersionOpensWholeAndItsUnfinishedRunGoesOn) {
  const std::vector<fs::path> studies = kept_studies();
  ASSERT_FALSE(studies.empty());
  for (const fs::path& kept : studies) {
    fs::copy_file(kept, path_, fs::copy_options::overwrite_existing);
    const auto check = check_study(path_);
    ASSERT_TRUE(check) << kept << ": " << check.error().message;
    EXPECT_TRUE(check->whole()) << kept;
    auto study = Study::open(path_);
    ASSERT_TRUE(study) << kept << ": " << study.error().message;
    EXPECT_EQ(study->world().kind, "uav") << kept;
    const auto runs = study->runs();
    ASSERT_TRUE(runs) << kept << ": " << runs.error().message;
    ASSERT_EQ(runs->size(), 3U) << kept;
    for (const RunRecord& run : *runs) {
      EXPECT_TRUE(study->best_tree(run.id)) << kept;
    }
    EXPECT_FALSE(study->front((*runs)[1].id)->members.empty()) << kept;
    EXPECT_EQ((*runs)[2].status, RunStatus::interrupted) << kept;
    const auto resumed = study->resume_run((*runs)[2].id);
    ASSERT_TRUE(resumed) << kept << ": " << resumed.error().message;
    EXPECT_TRUE(resumed->checkpoint) << kept;
  }
}

}  // namespace
}  // namespace coppice
