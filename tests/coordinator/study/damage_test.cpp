// What a study file that is not as it should be gets: one message that names it, never a crash, never a wrong chain.
#include <SQLiteCpp/SQLiteCpp.h>
#include <algorithm>
#include <filesystem>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "tests/coordinator/study/study_fixture.hpp"

namespace coppice {
namespace {

using testing::StudyFiles;
using testing::tree_of;

class DamageTest : public StudyFiles {
 protected:
  void refused(const std::string& because) {
    for (const Study::Access access : {Study::Access::read, Study::Access::write}) {
      const auto study = Study::open(path_, access);
      ASSERT_FALSE(study.has_value());
      EXPECT_EQ(study.error().kind, study.error().message.find(": damaged: ") != std::string::npos
                                        ? ErrorKind::damaged
                                        : ErrorKind::bad_input);
      EXPECT_EQ(study.error().message.rfind(path_ + ": ", 0), 0U) << study.error().message;
      EXPECT_NE(study.error().message.find(because), std::string::npos) << study.error().message;
      EXPECT_EQ(study.error().message.find('\n'), std::string::npos);
    }
  }

  void sql(const std::string& statement) { SQLite::Database(path_, SQLite::OPEN_READWRITE).exec(statement); }
};

TEST_F(DamageTest, AFileThatIsNoStudyIsNamed) {
  refused("No such file or directory");
  std::filesystem::create_directory(path_);
  refused("not a file");
  std::filesystem::remove(path_);
  overwrite("");
  refused("is empty");
  overwrite("####\n#^.#\n####\n");
  refused("not an SQLite database");
  overwrite(std::string(100'000, 'x'));
  refused("not an SQLite database");
  std::filesystem::remove(path_);
  SQLite::Database(path_, SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE).exec("CREATE TABLE study(id INTEGER)");
  refused("an SQLite database of some other program");
}

TEST_F(DamageTest, ANewerStudyIsNotGuessedAt) {
  { make(); }
  sql("PRAGMA user_version = 5");
  refused("a study of schema version 5: this program knows version 4 and is too old for it");
}

TEST_F(DamageTest, AChainThatIsNotTheOneThatWasStoredIsRefused) {
  { make(); }
  sql("UPDATE study SET chain = CAST(substr(chain, 1, 100) || x'FF' || substr(chain, 102) AS BLOB)");
  refused("damaged: the chain hashes to ");
  sql("UPDATE study SET chain = x''");
  refused("damaged: the chain hashes to ");
  sql("DELETE FROM study");
  refused("damaged: it holds no chain");
}

TEST_F(DamageTest, ACutFileIsNeverTakenForAWholeOne) {
  {
    Study study = make();
    const RunId id = study.begin_run({config(), "serial"}).value();
    evolve_into(study, id, config());
  }
  const std::string whole = content();
  for (std::size_t size = 0; size < whole.size(); size += std::max<std::size_t>(whole.size() / 97, 1)) {
    overwrite(std::string_view(whole).substr(0, size));
    for (const Study::Access access : {Study::Access::read, Study::Access::write}) {
      const auto study = Study::open(path_, access);
      ASSERT_FALSE(study.has_value()) << "cut at " << size << " of " << whole.size();
      EXPECT_EQ(study.error().message.rfind(path_ + ": ", 0), 0U);
    }
  }
}

TEST_F(DamageTest, AFlippedByteIsAnErrorOrHarmlessButNeverAWrongChainOrCheckpoint) {
  std::optional<Checkpoint> checkpoint;
  const RunId id{1};
  {
    Study study = make();
    ASSERT_EQ(study.begin_run({config(), "serial"}).value(), id);
    evolve_into(study, id, config());
    checkpoint = study.load_checkpoint(id).value();
  }
  const std::string whole = content();
  int refused_files = 0;
  constexpr std::size_t kFlips = 400;
  for (std::size_t i = 0; i < kFlips; ++i) {
    std::string flipped = whole;
    const std::size_t at = i < 100 ? i : i * 2654435761U % whole.size();  // the header byte by byte, then anywhere
    flipped[at] = static_cast<char>(flipped[at] ^ (1 << (i % 8)));
    overwrite(flipped);
    const auto study = Study::open(path_, Study::Access::read);
    if (!study) {
      ++refused_files;
      EXPECT_EQ(study.error().message.rfind(path_ + ": ", 0), 0U) << study.error().message;
      continue;
    }
    EXPECT_EQ(study->chain().parts(), chain_.parts()) << "byte " << at;
    if (const auto read = study->load_checkpoint(id); read && read->has_value()) {
      EXPECT_EQ((*read)->population, checkpoint->population) << "byte " << at;
      EXPECT_EQ((*read)->fitness, checkpoint->fitness) << "byte " << at;
    }
    static_cast<void>(study->runs());
    static_cast<void>(study->generations(id));
  }
  EXPECT_GT(refused_files, 0);
}

TEST_F(DamageTest, DamagedRowsAreNamed) {
  {
    Study study = make();
    const RunId id = study.begin_run({config(), "serial"}).value();
    evolve_into(study, id, config());
  }
  const auto after = [&](const std::string& statement) {
    sql(statement);
    return Study::open(path_, Study::Access::read).value();
  };
  EXPECT_EQ(
      message(
          after("UPDATE checkpoints SET population = replace(population, 'move', 'left')").load_checkpoint(RunId{1})),
      path_ + ": damaged: run 1: the checkpoint does not match its hash");
  EXPECT_EQ(message(after("DELETE FROM generations WHERE generation = 3").generations(RunId{1})),
            path_ + ": damaged: run 1, generation 3: missing");
  EXPECT_NE(message(after("UPDATE generations SET best_tree = '(oops' WHERE generation = 0").generations(RunId{1}))
                .find("damaged: run 1, generation 0: "),
            std::string::npos);
  EXPECT_NE(message(after("UPDATE runs SET tree = 'fly'").runs()).find("damaged: run 1: "), std::string::npos);
  EXPECT_NE(message(after("UPDATE runs SET tree = NULL, config = '{'").runs()).find("damaged: run 1: configuration"),
            std::string::npos);
}

}  // namespace
}  // namespace coppice
