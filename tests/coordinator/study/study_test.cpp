#include "coordinator/study/study.hpp"

#include <cmath>
#include <cstring>
#include <filesystem>
#include <gtest/gtest.h>
#include <limits>
#include <string>
#include <vector>

#include "tests/coordinator/evolution/small_world.hpp"
#include "tests/coordinator/study/study_fixture.hpp"

namespace coppice {
namespace {

using testing::StudyFiles;
using testing::tree_of;
using testing::WalkingEvaluator;

using StudyTest = StudyFiles;

TEST_F(StudyTest, GivesBackWhatItWasMadeOf) {
  const Study made = make();
  for (const Study::Access access : {Study::Access::read, Study::Access::write}) {
    const auto study = Study::open(path_, access);
    ASSERT_TRUE(study.has_value()) << study.error().message;
    EXPECT_EQ(study->path(), path_);
    EXPECT_EQ(study->chain().parts(), chain_.parts());
    EXPECT_EQ(study->chain_hash(), hash_of(to_bytes(chain_)));
    EXPECT_EQ(study->world(), world_);
    EXPECT_EQ(study->learning(), learning_);
    EXPECT_TRUE(study->runs().value().empty());
    EXPECT_EQ(study->last_run().value().has_value(), false);
  }
}

TEST_F(StudyTest, KeepsARunWithItsStatisticsAndResult) {
  Study study = make();
  NewRun run{config(), "2 local workers"};
  run.config.seed = std::numeric_limits<std::uint64_t>::max();
  const RunId id = study.begin_run(run).value();
  const std::vector<GenerationRecord> records = evolve_into(study, id, run.config);
  const RunRecord running = study.run(id).value();
  EXPECT_EQ(running.status, RunStatus::running);
  EXPECT_FALSE(running.abandoned);
  EXPECT_EQ(running.ended, "");
  EXPECT_EQ(running.generations, run.config.ga.generations);
  const RunOutcome outcome{RunStatus::finished, tree_of("(selector (sequence a=0 left) move)"), tree_of("move"),
                           R"({"fitness":1.5})"};
  ASSERT_TRUE(study.finish_run(id, outcome).has_value());

  const Study again = reopen(std::move(study));
  const RunRecord record = again.run(id).value();
  EXPECT_EQ(record.id, id);
  EXPECT_EQ(record.config, run.config);
  EXPECT_EQ(record.evaluator, run.evaluator);
  EXPECT_EQ(record.status, RunStatus::finished);
  EXPECT_EQ(record.tree, outcome.tree);
  EXPECT_EQ(record.pruned, outcome.pruned);
  EXPECT_EQ(record.json, outcome.json);
  EXPECT_EQ(record.started.size(), std::strlen("2016-11-09T12:34:56Z"));
  EXPECT_GE(record.ended, record.started);
  EXPECT_EQ(again.generations(id).value(), records);
  EXPECT_EQ(again.best_tree(id).value(), *outcome.tree);
}

TEST_F(StudyTest, NumbersRunsInTheOrderOfTheirStart) {
  Study study = make();
  for (int i = 0; i < 3; ++i) {
    NewRun run{config(), "serial"};
    run.config.seed = static_cast<std::uint64_t>(i);
    EXPECT_EQ(study.begin_run(run).value(), RunId{i + 1});
  }
  const auto runs = study.runs().value();
  ASSERT_EQ(runs.size(), 3U);
  EXPECT_EQ(runs[2].config.seed, 2U);
  EXPECT_EQ(study.last_run().value()->id, RunId{3});
  EXPECT_EQ(message(study.run(RunId{4})), path_ + ": no run 4: expected 1 to 3");
}

TEST_F(StudyTest, ResumesARunToTheVerySameResult) {
  Study study = make();
  WalkingEvaluator evaluator(chain_);
  const Evolved expected = evolve(chain_, config(), evaluator, std::nullopt, {}).value();
  const RunId id = study.begin_run({config(), "serial"}).value();
  WalkingEvaluator stopped(chain_);
  stopped.stop_at = 4;
  ASSERT_TRUE(evolve(chain_, config(), stopped, std::nullopt, saving_hooks(study, id)).value().interrupted);
  ASSERT_TRUE(study.finish_run(id, {RunStatus::interrupted, {}, {}}).has_value());

  Study again = reopen(std::move(study));
  const auto resumed = again.resume_run(id);
  ASSERT_TRUE(resumed.has_value()) << resumed.error().message;
  ASSERT_TRUE(resumed->checkpoint.has_value());
  EXPECT_EQ(resumed->checkpoint->generation, 3U);
  EXPECT_EQ(again.run(id).value().status, RunStatus::running);
  EXPECT_EQ(again.run(id).value().ended, "");
  EXPECT_EQ(evolve(chain_, resumed->config, evaluator, resumed->checkpoint, saving_hooks(again, id)).value(), expected);
  EXPECT_EQ(again.run(id).value().generations, config().ga.generations);
}

TEST_F(StudyTest, ACheckpointComesBackBitForBit) {
  Study study = make();
  const RunId id = study.begin_run({config(), "serial"}).value();
  EXPECT_EQ(study.load_checkpoint(id).value(), std::nullopt);
  EXPECT_EQ(message(study.best_tree(id)), path_ + ": run 1 has not one generation yet: expected one or more");
  Checkpoint checkpoint;
  for (const double fitness : {0.1, 1.0 / 3.0, -1e300, 5e-324, 2.0, std::nextafter(1.0, 2.0)}) {
    checkpoint.population.push_back(tree_of("(selector (sequence a=0 d<=1 left) move)"));
    checkpoint.fitness.push_back(fitness);
  }
  checkpoint.archive = {tree_of("(sequence b=3 right)"), tree_of("left")};
  GenerationRecord record;
  record.best = {tree_of("right"), 0, 1.0 / 3.0, 0.1};
  enter(record.best, checkpoint.hall_of_fame);
  ASSERT_TRUE(study.save_generations(id, {&record, 1}, checkpoint).has_value());
  const Study again = reopen(std::move(study));
  EXPECT_EQ(again.load_checkpoint(id).value(), checkpoint);
  EXPECT_EQ(again.best_tree(id).value(), tree_of("right"));
}

TEST_F(StudyTest, TheGenerationsOfAnEpochAreSavedAtOnceWithTheDemesAsTheyStood) {
  Study study = make();
  const RunId id = study.begin_run({config(), "serial"}).value();
  Checkpoint checkpoint;
  checkpoint.generation = 1;
  checkpoint.population = {tree_of("move"), tree_of("left"), tree_of("right"), tree_of("(sequence b=3 right)")};
  checkpoint.fitness = {0.1, 0.2, 0.3, 1.0 / 3.0};
  std::vector<GenerationRecord> records(2);
  for (std::uint32_t generation = 0; generation < 2; ++generation) {
    records[generation].generation = generation;
    records[generation].best = {tree_of("right"), generation, 0.5, 0.1};
    enter(records[generation].best, checkpoint.hall_of_fame);
  }
  // Archives that are empty, of one tree and of two, at either end and between.
  for (const std::vector<std::size_t>& kept :
       {std::vector<std::size_t>{0, 0, 0}, std::vector<std::size_t>{1, 0, 2}, std::vector<std::size_t>{0, 2, 0}}) {
    checkpoint.kept = kept;
    checkpoint.archive.clear();
    for (const std::size_t of_deme : kept) {
      checkpoint.archive.insert(checkpoint.archive.end(), of_deme, tree_of("(sequence a=0 left)"));
    }
    ASSERT_TRUE(study.rewind_run(id, std::nullopt).has_value());
    ASSERT_TRUE(study.save_generations(id, records, checkpoint).has_value());
    EXPECT_EQ(study.load_checkpoint(id).value(), checkpoint);
    EXPECT_EQ(study.generations(id).value().size(), 2U);
  }
}

TEST_F(StudyTest, AFrontComesBackBitForBit) {
  Study study = make();
  const RunId id = study.begin_run({config(), "serial"}).value();
  EXPECT_EQ(study.front(id).value(), Front{});
  const std::vector<Measure> measures = {measure_of(ObjectiveKind::agreement),
                                         measure_of(ObjectiveKind::expected_return), kNodesMeasure};
  Front front{measures, {{tree_of("move"), 1.0 / 3.0, {0.1, -17.25, 1}}, {tree_of("left"), 0.5, {0.2, 5e-324, 1}}}};
  ASSERT_TRUE(study.save_front(id, front).has_value());
  EXPECT_EQ(study.front(id).value(), front);
  front.members.pop_back();
  ASSERT_TRUE(study.save_front(id, front).has_value());
  const Study again = reopen(std::move(study));
  EXPECT_EQ(again.front(id).value(), front) << "the one before is gone";
}

TEST_F(StudyTest, SavesAGenerationOnce) {
  Study study = make();
  const RunId id = study.begin_run({config(), "serial"}).value();
  Checkpoint checkpoint{0, {tree_of("move")}, {0.5}, {}};
  ASSERT_TRUE(study.save_generations(id, std::vector<GenerationRecord>(1), checkpoint).has_value());
  checkpoint.fitness = {0.75};
  const auto second = study.save_generations(id, std::vector<GenerationRecord>(1), checkpoint);
  ASSERT_FALSE(second.has_value());
  EXPECT_EQ(second.error().message.rfind(path_ + ": ", 0), 0U);
  EXPECT_EQ(study.load_checkpoint(id).value()->fitness, std::vector<double>{0.5}) << "half of a transaction was kept";
}

TEST_F(StudyTest, GoesBackToACheckpoint) {
  Study study = make();
  const RunId id = study.begin_run({config(), "serial"}).value();
  const RunId other = study.begin_run({config(), "serial"}).value();
  const auto save = [&](RunId run, std::uint32_t generation) {
    Checkpoint checkpoint{generation, {tree_of("move")}, {0.5 + generation}, {}};
    GenerationRecord record{.generation = generation, .best = {tree_of("move"), 0, 0.5, 0.25}};
    enter(record.best, checkpoint.hall_of_fame);
    EXPECT_TRUE(study.save_generations(run, {&record, 1}, checkpoint).has_value());
    return checkpoint;
  };
  save(other, 0);
  const Checkpoint first = save(id, 0);
  save(id, 1);
  const Checkpoint last = save(id, 2);
  ASSERT_TRUE(study.rewind_run(id, first).has_value());
  EXPECT_EQ(study.load_checkpoint(id).value(), first);
  EXPECT_EQ(study.generations(id).value().size(), 1U);
  save(id, 1);
  EXPECT_EQ(save(id, 2), last);
  ASSERT_TRUE(study.rewind_run(id, std::nullopt).has_value());
  EXPECT_EQ(study.load_checkpoint(id).value(), std::nullopt);
  EXPECT_TRUE(study.generations(id).value().empty());
  EXPECT_EQ(study.generations(other).value().size(), 1U) << "another run's";
  EXPECT_EQ(save(id, 0), first);
}

TEST_F(StudyTest, KeepsDemesWithTheGenerationsThatTheyBelongTo) {
  Study study = make();
  const RunId id = study.begin_run({config(), "serial"}).value();
  EXPECT_TRUE(study.deme_generations(id).value().demes.empty()) << "no table yet";
  ASSERT_TRUE(study.rewind_run(id, std::nullopt).has_value()) << "no table yet";
  const auto save = [&](std::uint32_t generation, std::size_t demes) {
    Checkpoint checkpoint{generation, {tree_of("move")}, {0.5}, {}};
    std::vector<std::vector<GenerationRecord>> of_demes(demes);
    for (std::size_t deme = 0; deme < demes; ++deme) {
      GenerationRecord record{.generation = generation,
                              .best = {tree_of("move"), 0, 0.5 + static_cast<double>(deme), 0.25}};
      record.mean_fitness = 0.1;
      record.mean_nodes = 2.5;
      record.evaluations = 10;
      of_demes[deme].push_back(record);
    }
    EXPECT_TRUE(study.save_generations(id, of_demes.front(), checkpoint, of_demes).has_value());
    return checkpoint;
  };
  const Checkpoint first = save(0, 2);
  save(1, 2);
  EXPECT_EQ(study.deme_generations(id).value().generation, (std::vector<std::uint32_t>{0, 1}));
  ASSERT_TRUE(study.rewind_run(id, first).has_value());
  const Study again = reopen(std::move(study));
  const auto kept = again.deme_generations(id).value();
  EXPECT_EQ(kept.generation, std::vector<std::uint32_t>{0});
  ASSERT_EQ(kept.demes.size(), 2U);
  EXPECT_EQ(kept.demes[1],
            (std::vector<DemeGeneration>{
                {.best_fitness = 1.5, .mean_fitness = 0.1, .best_nodes = 1, .mean_nodes = 2.5, .evaluations = 10}}));
}

TEST_F(StudyTest, ADemeThatMissesGenerationsIsDamage) {
  Study study = make();
  const RunId id = study.begin_run({config(), "serial"}).value();
  for (std::uint32_t generation = 0; generation < 2; ++generation) {
    GenerationRecord record{.generation = generation, .best = {tree_of("move"), 0, 0.5, 0.25}};
    std::vector<std::vector<GenerationRecord>> of_demes(generation == 0 ? 2 : 1, {record});
    ASSERT_TRUE(
        study.save_generations(id, {&record, 1}, {generation, {tree_of("move")}, {0.5}, {}}, of_demes).has_value());
  }
  const auto kept = study.deme_generations(id);
  ASSERT_FALSE(kept.has_value());
  EXPECT_EQ(kept.error().message.rfind(path_ + ": ", 0), 0U);
}

TEST_F(StudyTest, NeverOverwritesAFile) {
  { make(); }
  const std::string before = content();
  EXPECT_EQ(message(Study::create(path_, chain_, world_, learning_)),
            path_ + ": exists already: expected a new file, a study is never overwritten");
  EXPECT_EQ(content(), before);
  std::filesystem::create_symlink("nowhere", folder_ + "/link");
  EXPECT_NE(message(Study::create(folder_ + "/link", chain_, world_, learning_)).find("exists already"),
            std::string::npos);
  EXPECT_EQ(files(), (std::vector<std::string>{"link", "one.study"}));
}

TEST_F(StudyTest, LeavesNothingBehindWhenItCannotBeMade) {
  EXPECT_EQ(message(Study::create(folder_ + "/no/such.study", chain_, world_, learning_)),
            folder_ + "/no/such.study: there is no folder " + folder_ + "/no");
  EXPECT_NE(message(Study::create(path_, chain_, world_, {"[1]", "{}"})).find("learning.settings is not a JSON object"),
            std::string::npos);
  EXPECT_EQ(files(), std::vector<std::string>());
}

TEST_F(StudyTest, IsOneFileOnceClosed) {
  {
    Study study = make();
    const RunId id = study.begin_run({config(), "serial"}).value();
    evolve_into(study, id, config());
    EXPECT_EQ(files(), (std::vector<std::string>{"one.study", "one.study-shm", "one.study-wal"}));
  }
  EXPECT_EQ(files(), std::vector<std::string>{"one.study"});
}

TEST_F(StudyTest, OpenForReadingChangesNothing) {
  { make(); }
  const std::string before = content();
  {
    auto study = Study::open(path_, Study::Access::read).value();
    EXPECT_EQ(message(study.begin_run({config(), "serial"})).rfind(path_ + ": cannot be written", 0), 0U);
    EXPECT_EQ(files(), std::vector<std::string>{"one.study"});
  }
  EXPECT_EQ(content(), before);
}

TEST_F(StudyTest, CanBeReadWhileARunIsWritingIt) {
  Study writer = make();
  const RunId id = writer.begin_run({config(), "serial"}).value();
  const Study reader = Study::open(path_, Study::Access::read).value();
  const auto records = evolve_into(writer, id, config());
  EXPECT_EQ(reader.generations(id).value(), records);
  EXPECT_EQ(reader.run(id).value().status, RunStatus::running);
}

TEST_F(StudyTest, IsItselfAfterAMove) {
  Study study = make();
  Study other = std::move(study);
  study = std::move(other);
  EXPECT_EQ(study.chain().states(), chain_.states());
}

}  // namespace
}  // namespace coppice
