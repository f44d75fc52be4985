// Copies of a study that is in use, a look through all of it, and that one process at a time evolves in it.
#include <SQLiteCpp/SQLiteCpp.h>
#include <algorithm>
#include <filesystem>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include "common/tree/text.hpp"
#include "coordinator/study/study_backup.hpp"
#include "coordinator/study/study_check.hpp"
#include "tests/coordinator/study/study_fixture.hpp"

namespace coppice {
namespace {

using testing::StudyFiles;

class BackupTest : public StudyFiles {
 protected:
  std::string copy() const { return path_ + ".copy"; }
  void TearDown() override {
    std::filesystem::remove(copy());
    StudyFiles::TearDown();
  }
  void sql(const std::string& statement) { SQLite::Database(path_, SQLite::OPEN_READWRITE).exec(statement); }

  // A finished run.
  void evolved() {
    Study study = make();
    const RunId id = study.begin_run({config(), "serial"}).value();
    evolve_into(study, id, config());
  }
};

TEST_F(BackupTest, IsWhatTheStudyHeldAtOneMomentWhileARunGoesOn) {
  Study study = make();
  const RunId id = study.begin_run({config(), "serial"}).value();
  EvolveHooks hooks;
  std::uint32_t copied_at = 0;
  hooks.generations_done = [&](std::span<const GenerationRecord> records, const Checkpoint& checkpoint) {
    auto saved = study.save_generations(id, records, checkpoint);
    if (saved && records.back().generation == 2) {
      saved = back_up_study(path_, copy());
      copied_at = records.back().generation;
    }
    return saved;
  };
  testing::WalkingEvaluator evaluator(study.chain());
  ASSERT_TRUE(evolve(study.chain(), config(), evaluator, std::nullopt, hooks));
  ASSERT_EQ(copied_at, 2U);
  ASSERT_GT(study.generations(id)->size(), 3U) << "the run went on";

  const auto kept = Study::open(copy(), Study::Access::read);
  ASSERT_TRUE(kept) << kept.error().message;
  EXPECT_EQ(kept->generations(id)->size(), 3U);
  EXPECT_EQ(kept->load_checkpoint(id)->value().generation, 2U);
  EXPECT_EQ(kept->chain_hash(), study.chain_hash());
  EXPECT_TRUE(check_study(copy())->whole());
  for (const char* journal : {"-wal", "-shm", "-journal"}) {
    EXPECT_FALSE(std::filesystem::exists(copy() + journal)) << "one file is the whole copy";
  }
}

TEST_F(BackupTest, OfNoStudyOrIntoNoFolderLeavesNothing) {
  EXPECT_FALSE(back_up_study(path_, copy()));
  { make(); }
  EXPECT_FALSE(back_up_study(path_, "/nowhere/at/all.coppice"));
  EXPECT_FALSE(std::filesystem::exists(copy()));
}

TEST_F(BackupTest, AWholeStudyIsCalledWhole) {
  evolved();
  const auto check = check_study(path_);
  ASSERT_TRUE(check) << check.error().message;
  EXPECT_TRUE(check->whole());
  ASSERT_EQ(check->runs.size(), 1U);
  EXPECT_EQ(check->runs[0].generations, config().ga.generations);
  EXPECT_FALSE(check_study("/nowhere.coppice")) << "nothing to look at";
}

TEST_F(BackupTest, DamageOfOneRunIsNamedAndTheTreesThatCanBeReadAreShown) {
  evolved();
  sql("UPDATE checkpoints SET population = replace(population, '0', '1')");
  const auto check = check_study(path_);
  ASSERT_TRUE(check) << check.error().message;
  EXPECT_FALSE(check->whole());
  ASSERT_EQ(check->runs.size(), 1U);
  ASSERT_FALSE(check->runs[0].damage.empty());
  EXPECT_NE(check->runs[0].damage[0].find("damaged"), std::string::npos) << check->runs[0].damage[0];
  EXPECT_FALSE(check->runs[0].resumable);
  EXPECT_FALSE(check->trees.empty());
}

TEST_F(BackupTest, OfAChainThatIsDamagedTheTreesCanStillBeSaved) {
  evolved();
  const std::string tree =
      to_text(Study::open(path_, Study::Access::read)->best_tree(RunId{1}).value(), chain_.vocabulary());
  sql("UPDATE study SET chain = CAST(substr(chain, 1, 100) || x'FF' || substr(chain, 102) AS BLOB)");
  const auto check = check_study(path_);
  ASSERT_TRUE(check) << check.error().message;
  EXPECT_FALSE(check->whole());
  ASSERT_FALSE(check->damage.empty());
  EXPECT_NE(std::find(check->trees.begin(), check->trees.end(), tree), check->trees.end());
}

TEST_F(BackupTest, ARunOfAnotherLivingProcessKeepsOthersOut) {
  { make(); }
  int ready[2];
  ASSERT_EQ(pipe(ready), 0);
  const pid_t child = fork();
  if (child == 0) {
    auto study = Study::open(path_);
    const bool begun = study && study->begin_run({config(), "serial"});
    [[maybe_unused]] const ssize_t told = write(ready[1], begun ? "y" : "n", 1);
    pause();
    _exit(0);
  }
  char begun = 'n';
  ASSERT_EQ(read(ready[0], &begun, 1), 1);
  EXPECT_EQ(begun, 'y');
  {
    Study study = Study::open(path_).value();
    const auto second = study.begin_run({config(), "serial"});
    ASSERT_FALSE(second);
    EXPECT_EQ(second.error().kind, ErrorKind::bad_input);
    EXPECT_NE(second.error().message.find("run 1 is being run by process " + std::to_string(child)), std::string::npos)
        << second.error().message;
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    EXPECT_TRUE(study.begin_run({config(), "serial"})) << "nobody runs it any more";
    EXPECT_TRUE(study.begin_run({config(), "serial"})) << "one process may run several";
  }
  close(ready[0]);
  close(ready[1]);
}

}  // namespace
}  // namespace coppice
