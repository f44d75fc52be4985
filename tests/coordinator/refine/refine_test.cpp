#include "coordinator/refine/refine.hpp"

#include <gtest/gtest.h>
#include <stdexcept>

#include "common/evolution/seeding.hpp"
#include "common/tree/text.hpp"
#include "coordinator/learning/learn.hpp"
#include "coordinator/refine/refine_report.hpp"
#include "tests/coordinator/evolution/small_world.hpp"
#include "tests/coordinator/learning/rooms.hpp"
#include "tests/temporary_folder.hpp"

namespace coppice {
namespace {

class RefineLoop : public ::testing::Test {
 protected:
  RefineLoop() {
    LearnSettings learning = default_settings(WorldKind::uav, Algorithm::q_learning);
    learning.episodes = 20;
    learning.steps = 30;
    const auto learned = learn(world_, learning, {});
    auto study = Study::create(folder_ / "study.coppice", learned->chain, {"uav", world_.room},
                               {R"({"steps": 30})", R"({"episodes": 20})"});
    study_.emplace(std::move(study.value()));
    config_.seed = 40;
    config_.ga.generations = 3;
    config_.ga.population = 10;
    settings_.rounds = 2;
    settings_.walks = {.episodes = 5, .steps = 30, .seed = 40};
    settings_.judged = {.episodes = 4, .steps = 30};
    hooks_.evolve = [this](Study& round, const EvolveConfig& config) -> Result<RoundAnswer> {
      testing::WalkingEvaluator evaluator(round.chain());
      const RunId run = round.begin_run({config, "serial"}).value();
      EvolveHooks hooks;
      hooks.generations_done = [&](std::span<const GenerationRecord> records, const Checkpoint& checkpoint) {
        return round.save_generations(run, records, checkpoint);
      };
      configs_.push_back(config);
      auto evolved = evolve(round.chain(), config, evaluator, std::nullopt, hooks);
      if (!evolved) {
        return tl::unexpected(evolved.error());
      }
      if (auto saved = round.save_front(run, evolved->front); !saved) {
        return tl::unexpected(saved.error());
      }
      return RoundAnswer{evolved->best.tree, interrupted_in_ == configs_.size()};
    };
    hooks_.round_done = [this](const RefineRound& round) { rounds_.push_back(round); };
  }

  Tree start() const {
    return parse_tree("(selector (sequence s3=0 turn_left) move)", study_->chain().vocabulary()).value();
  }

  Result<void> run(const std::string& folder) {
    std::filesystem::create_directory(folder_ / folder);
    rounds_.clear();
    configs_.clear();
    return refine(*study_, world_, start(), config_, settings_, std::filesystem::path(folder_ / folder), hooks_);
  }

  testing::TemporaryFolder folder_;
  const World world_ = testing::world(testing::small_room());
  std::optional<Study> study_;
  EvolveConfig config_;
  RefineSettings settings_;
  RefineHooks hooks_;
  std::vector<RefineRound> rounds_;
  std::vector<EvolveConfig> configs_;
  std::size_t interrupted_in_ = 0;
};

TEST_F(RefineLoop, GivesEveryRoundAStudyWhoseChainGrows) {
  const auto done = run("a");
  ASSERT_TRUE(done.has_value()) << done.error().message;
  ASSERT_EQ(rounds_.size(), 3U);
  EXPECT_FALSE(rounds_[0].gains);
  EXPECT_EQ(rounds_[0].chain, study_->chain_hash().hex());
  std::uint64_t before = 0;
  for (const std::uint32_t count : study_->chain().parts().count) {
    before += count;
  }
  for (std::uint32_t round = 1; round <= 2; ++round) {
    const Study grown = Study::open(study_of_round(folder_ / "a", round).string()).value();
    EXPECT_EQ(rounds_[round].study, grown.path());
    EXPECT_EQ(rounds_[round].chain, grown.chain_hash().hex());
    EXPECT_NE(rounds_[round].chain, rounds_[round - 1].chain);
    std::uint64_t counted = 0;
    for (const std::uint32_t count : grown.chain().parts().count) {
      counted += count;
    }
    EXPECT_EQ(counted, before + rounds_[round].gains->steps);
    EXPECT_LE(rounds_[round].gains->steps, 5U * 30U);
    before = counted;
    EXPECT_EQ(grown.learning().settings, R"({"steps": 30})");
    EXPECT_NE(grown.learning().outcome.find("\"refined\""), std::string::npos);
    EXPECT_EQ(rounds_[round].seed, 40 + round);
  }
  EXPECT_EQ(to_json(rounds_).size(), 3U);
  EXPECT_NE(to_text(rounds_).find("+ transitions"), std::string::npos);
}

TEST_F(RefineLoop, IsAPureFunctionOfItsInput) {
  ASSERT_TRUE(run("a").has_value());
  const std::vector<RefineRound> first = rounds_;
  ASSERT_TRUE(run("b").has_value());
  ASSERT_EQ(first.size(), rounds_.size());
  for (std::size_t round = 0; round < first.size(); ++round) {
    EXPECT_EQ(first[round].chain, rounds_[round].chain);
    EXPECT_EQ(first[round].gains, rounds_[round].gains);
    EXPECT_EQ(first[round].score->tree_text, rounds_[round].score->tree_text);
  }
  settings_.walks.seed = 41;
  ASSERT_TRUE(run("c").has_value());
  EXPECT_NE(first[1].chain, rounds_[1].chain) << "other luck meets other things";
}

TEST_F(RefineLoop, BeginsARoundWithTheTreeThatWasWalkedAndItsFront) {
  config_.ga.search = Search::front;
  config_.ga.population = 20;
  config_.ga.founders = "(selector move turn_left)";
  ASSERT_TRUE(run("a").has_value());
  const Vocabulary& vocabulary = study_->chain().vocabulary();
  const auto first = founders_of(configs_[0].ga, vocabulary).value();
  EXPECT_EQ(first, (std::vector<Tree>{parse_tree("(selector move turn_left)", vocabulary).value(), start()}));
  const Study round = Study::open(study_of_round(folder_ / "a", 1).string()).value();
  const auto second = founders_of(configs_[1].ga, vocabulary).value();
  const Front front = round.front(RunId{1}).value();
  EXPECT_GT(second.size(), 1U);
  EXPECT_LE(second.size(), 10U) << "half a generation is new";
  EXPECT_EQ(to_text(second[1], vocabulary), rounds_[1].score->tree_text);
  for (std::size_t i = 2; i < second.size(); ++i) {
    EXPECT_TRUE(std::any_of(front.members.begin(), front.members.end(),
                            [&](const FrontMember& member) { return member.tree == second[i]; }));
  }
}

TEST_F(RefineLoop, KeepsTheRoundsBeforeAnInterruption) {
  interrupted_in_ = 2;
  const auto stopped = run("a");
  ASSERT_FALSE(stopped.has_value());
  EXPECT_EQ(stopped.error().kind, ErrorKind::interrupted);
  ASSERT_EQ(rounds_.size(), 3U);
  EXPECT_TRUE(rounds_[1].score.has_value());
  EXPECT_FALSE(rounds_[2].score.has_value());
  EXPECT_TRUE(Study::open(rounds_[2].study).has_value()) << "with the best so far";
  EXPECT_NE(to_text(rounds_).find("interrupted"), std::string::npos);

  std::uint64_t asked = 0;
  hooks_.go_on = [&] { return ++asked < 7; };  // four episodes judge round 0's policy, two its tree
  const auto walking = run("b");
  ASSERT_FALSE(walking.has_value());
  EXPECT_EQ(walking.error().kind, ErrorKind::interrupted);
  EXPECT_TRUE(std::filesystem::is_empty(folder_ / "b"));
}

RefineRound round_with(std::uint64_t collisions, double reward) {
  RefineRound round;
  round.score.emplace();
  round.score->tree.total_collisions = collisions;
  round.score->tree.reward.mean = reward;
  return round;
}

TEST(BestRound, CollidesLeastThenEarnsMostThenCameFirst) {
  EXPECT_EQ(best_of({}), std::nullopt);
  EXPECT_EQ(best_of({RefineRound{}}), std::nullopt) << "an interrupted round has no score";
  EXPECT_EQ(best_of({round_with(0, 265.0), round_with(0, 105.0)}), 0U) << "the last is not the best for being last";
  EXPECT_EQ(best_of({round_with(3, 300.0), round_with(1, 100.0), round_with(1, 120.0), RefineRound{}}), 2U);
  EXPECT_EQ(best_of({round_with(1, 100.0), round_with(1, 100.0)}), 0U);
}

TEST_F(RefineLoop, HandsTheBestTreeOnEvenIfTheLastRoundWasWorse) {
  // Whatever evolution does, round 1 answers with a tree that runs into the first wall; the start never does.
  const Vocabulary& vocabulary = study_->chain().vocabulary();
  const auto evolve_as_before = hooks_.evolve;
  hooks_.evolve = [&](Study& round, const EvolveConfig& config) {
    auto answer = evolve_as_before(round, config);
    if (answer && configs_.size() == 1) {
      answer->tree = parse_tree("move", vocabulary).value();
    }
    return answer;
  };
  ASSERT_TRUE(run("a").has_value());
  ASSERT_GT(rounds_[1].score->tree.total_collisions, rounds_[0].score->tree.total_collisions);
  const auto second = founders_of(configs_[1].ga, vocabulary).value();
  EXPECT_EQ(second[0], parse_tree("move", vocabulary).value()) << "what was walked";
  EXPECT_EQ(second[1], start()) << "what is best so far";
}

TEST(RefineSettings, RefusesNumbersOutOfRangeByTheirFlag) {
  RefineSettings settings;
  EXPECT_TRUE(check_settings(settings).has_value());
  settings.rounds = 0;
  EXPECT_EQ(check_settings(settings).error().message, "--rounds is 0: expected 1 to 1000");
  settings.rounds = 1;
  settings.walks.episodes = 1;
  EXPECT_EQ(check_settings(settings).error().message.rfind("--episodes is 1", 0), 0U);
  settings.walks.episodes = 2;
  settings.judged.episodes = 0;
  EXPECT_EQ(check_settings(settings).error().message.rfind("--score-episodes is 0", 0), 0U);
}

}  // namespace
}  // namespace coppice
