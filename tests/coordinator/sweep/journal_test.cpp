#include "coordinator/sweep/journal.hpp"

#include <fstream>
#include <gtest/gtest.h>

#include "tests/coordinator/evolution/small_world.hpp"
#include "tests/temporary_folder.hpp"

namespace coppice {
namespace {

class Journal : public ::testing::Test {
 protected:
  SweepJournal open(std::uint64_t episodes = 5, std::uint8_t chain = 1) const {
    ChainHash hash;
    hash.bytes.fill(chain);
    auto journal = SweepJournal::open(folder_ / "runs.jsonl", hash, episodes, testing::small_vocabulary());
    EXPECT_TRUE(journal.has_value()) << journal.error().message;
    return std::move(*journal);
  }

  static SweepResult result() {
    SweepResult result;
    result.fitness = 1.0 / 3.0;
    result.agreement = 0.1;
    result.distinct = 0.6;
    result.meanings = 0.3;
    result.nodes = 3;
    result.tree = testing::tree_of("(selector (sequence a=0 left) move)");
    result.simulated = SweepResult::Simulated{0.7, -1e-300, 2.0};
    result.seconds = 0.25;
    return result;
  }

  testing::TemporaryFolder folder_;
};

TEST_F(Journal, GivesBackWhatWasAddedToTheBit) {
  EvolveConfig config;
  config.seed = 7;
  ASSERT_TRUE(open().add(config, result()).has_value());
  const SweepJournal again = open();
  ASSERT_NE(again.find(config), nullptr);
  EXPECT_EQ(*again.find(config), result());
  config.seed = 8;
  EXPECT_EQ(again.find(config), nullptr);
}

TEST_F(Journal, KeepsRunsOfOtherChainsAndEpisodesApart) {
  ASSERT_TRUE(open().add(EvolveConfig{}, result()).has_value());
  EXPECT_EQ(open(6).find(EvolveConfig{}), nullptr);
  EXPECT_EQ(open(5, 2).find(EvolveConfig{}), nullptr);
  EXPECT_NE(open().find(EvolveConfig{}), nullptr);
}

TEST_F(Journal, RepeatsARunWhoseLineWasCutShortAndGoesOnBehindIt) {
  EvolveConfig second;
  second.seed = 2;
  ASSERT_TRUE(open().add(EvolveConfig{}, result()).has_value());
  ASSERT_TRUE(open().add(second, result()).has_value());
  const std::string path = folder_ / "runs.jsonl";
  std::filesystem::resize_file(path, std::filesystem::file_size(path) - 9);
  {
    SweepJournal journal = open();
    EXPECT_NE(journal.find(EvolveConfig{}), nullptr);
    EXPECT_EQ(journal.find(second), nullptr);
    ASSERT_TRUE(journal.add(second, result()).has_value());
  }
  EXPECT_NE(open().find(second), nullptr);
}

TEST_F(Journal, RevokesWhatThisProcessAddedAndNothingElse) {
  EvolveConfig second;
  second.seed = 2;
  ASSERT_TRUE(open().add(EvolveConfig{}, result()).has_value());
  {
    SweepJournal journal = open();
    ASSERT_TRUE(journal.add(second, result()).has_value());
    EXPECT_EQ(journal.revoke_added(), 1U);
    EXPECT_EQ(journal.find(second), nullptr);
  }
  SweepJournal again = open();
  EXPECT_EQ(again.find(second), nullptr);
  EXPECT_NE(again.find(EvolveConfig{}), nullptr);
  ASSERT_TRUE(again.add(second, result()).has_value());
  EXPECT_NE(open().find(second), nullptr);
}

TEST_F(Journal, TellsTheFirstLineOfAnotherSweep) {
  EvolveConfig second;
  second.seed = 2;
  ASSERT_TRUE(open().add(EvolveConfig{}, result()).has_value());
  ASSERT_TRUE(open().add(second, result()).has_value());
  ASSERT_TRUE(open(5, 2).add(EvolveConfig{}, result()).has_value());
  const SweepRun first_run{.setting = 0, .config = {}};
  const SweepRun second_run{.setting = 0, .config = second};
  EXPECT_EQ(open().line_beside({first_run, second_run}), 3U);
  EXPECT_EQ(open().line_beside({first_run}), 2U);
  EXPECT_EQ(open(5, 2).line_beside({first_run}), 1U);
}

}  // namespace
}  // namespace coppice
