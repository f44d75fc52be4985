// A run in several demes is the same whoever runs its epochs, in whatever order they end, and wherever it was resumed.
#include <algorithm>
#include <gtest/gtest.h>
#include <memory>
#include <optional>
#include <vector>

#include "common/chain/random.hpp"
#include "common/stop.hpp"
#include "coordinator/dispatch/deme_evolver.hpp"
#include "coordinator/dispatch/serial_evaluator.hpp"
#include "coordinator/evolution/deme_graph.hpp"
#include "coordinator/evolution/evolve.hpp"
#include "tests/coordinator/evolution/small_world.hpp"

namespace coppice {
namespace {

using testing::small_chain;

EvolveConfig deme_config(Search search, Migration migration = Migration::ring) {
  EvolveConfig config;
  config.seed = 42;
  config.ga.search = search;
  config.ga.generations = 11;  // the last epoch is shorter
  config.ga.population = 50;   // some demes have one more
  config.ga.demes = 4;
  config.ga.epoch = 3;
  config.ga.migrants = 2;
  config.ga.migration = migration;
  config.rollout.rollouts = 2;
  config.rollout.steps = 30;
  config.rollout.final_rollouts = 10;
  if (search == Search::front) {
    config.ga.edits = 0.5;
    config.ga.local_search = 0.3;
    config.ga.max_nodes = 16;
    config.front.max_nodes = 12;
    config.front.members = 15;
    config.front.objectives = {measure_of(ObjectiveKind::agreement), measure_of(ObjectiveKind::coverage),
                               kNodesMeasure};
  }
  return config;
}

// Ends epochs in an order of its own.
class ShufflingEvolver : public DemeEvolver {
 public:
  ShufflingEvolver(std::shared_ptr<const PreparedChain> chain, std::uint64_t seed)
      : runner_(std::move(chain)), order_(seed) {}

  void submit(std::uint64_t ticket, std::shared_ptr<const EvolveConfig> config, EpochTask task) override {
    waiting_.push_back({ticket, std::move(config), std::move(task)});
  }
  Result<Finished> next() override {
    std::swap(waiting_[order_.below(waiting_.size())], waiting_.back());
    const Waiting waiting = std::move(waiting_.back());
    waiting_.pop_back();
    auto result = runner_.run(*waiting.config, waiting.task, [](std::size_t) { return true; });
    return result ? Result<Finished>(Finished{waiting.ticket, std::move(*result)}) : tl::unexpected(result.error());
  }

 private:
  struct Waiting {
    std::uint64_t ticket;
    std::shared_ptr<const EvolveConfig> config;
    EpochTask task;
  };
  EpochRunner runner_;
  Xoshiro256 order_;
  std::vector<Waiting> waiting_;
};

// Evaluates slots and nothing else.
class SlotsOnly : public Evaluator {
 public:
  SlotsOnly(std::shared_ptr<const Chain> chain, const StopFlag& stop)
      : slots_(SerialEvaluator::make(std::move(chain), stop).value()) {}
  Result<std::vector<Tally>> evaluate(std::span<const Tree> trees, const Job& job) override {
    return slots_->evaluate(trees, job);
  }
  DispatchStatistics statistics() const override { return {}; }

 private:
  std::unique_ptr<Evaluator> slots_;
};

class Shuffling : public SlotsOnly {
 public:
  Shuffling(const std::shared_ptr<const Chain>& chain, const StopFlag& stop, std::uint64_t seed)
      : SlotsOnly(chain, stop), demes_(PreparedChain::make(chain), seed) {}
  DemeEvolver* demes(const EvolveConfig&) override { return &demes_; }

 private:
  ShufflingEvolver demes_;
};

struct History {
  std::vector<GenerationRecord> records;
  std::vector<Checkpoint> checkpoints;

  EvolveHooks hooks() {
    return {.generations_done = [this](std::span<const GenerationRecord> epoch,
                                       const Checkpoint& checkpoint) -> Result<void> {
      for (const GenerationRecord& record : epoch) {
        records.push_back(record);
        records.back().seconds = 0.0;
      }
      checkpoints.push_back(checkpoint);
      return {};
    }};
  }
};

class Demes : public ::testing::TestWithParam<Search> {
 protected:
  Result<Evolved> run(Evaluator& evaluator, const EvolveConfig& config, History& history,
                      std::optional<Checkpoint> start = std::nullopt) {
    return evolve(*chain_, config, evaluator, std::move(start), history.hooks());
  }

  std::shared_ptr<const Chain> chain_ = std::make_shared<const Chain>(small_chain());
  StopFlag stop_;
};

TEST_P(Demes, EndTheSameOnAnyNumberOfThreadsInAnyOrderAndSlotBySlot) {
  for (const Migration migration : {Migration::ring, Migration::random}) {
    const EvolveConfig config = deme_config(GetParam(), migration);
    SlotsOnly slots(chain_, stop_);
    History expected_history;
    const auto expected = run(slots, config, expected_history);
    ASSERT_TRUE(expected.has_value()) << expected.error().message;
    EXPECT_EQ(expected_history.records.size(), config.ga.generations);
    EXPECT_EQ(expected_history.checkpoints.size(), 4U);
    for (const std::size_t threads : {1U, 2U, 5U}) {
      const auto evaluator = SerialEvaluator::make(chain_, stop_, threads).value();
      History history;
      EXPECT_EQ(run(*evaluator, config, history).value(), *expected) << threads << " threads";
      EXPECT_EQ(history.records, expected_history.records);
      EXPECT_EQ(history.checkpoints, expected_history.checkpoints);
    }
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      Shuffling evaluator(chain_, stop_, seed);
      History history;
      EXPECT_EQ(run(evaluator, config, history).value(), *expected) << "order " << seed;
      EXPECT_EQ(history.records, expected_history.records);
      EXPECT_EQ(history.checkpoints, expected_history.checkpoints);
    }
  }
}

TEST_P(Demes, ResumeFromAnyCheckpointToTheVerySameResult) {
  const EvolveConfig config = deme_config(GetParam());
  const auto evaluator = SerialEvaluator::make(chain_, stop_, 2).value();
  History whole;
  const auto expected = run(*evaluator, config, whole);
  ASSERT_TRUE(expected.has_value());
  for (std::size_t epoch = 0; epoch < whole.checkpoints.size(); ++epoch) {
    History rest;
    const auto resumed = run(*evaluator, config, rest, whole.checkpoints[epoch]);
    ASSERT_TRUE(resumed.has_value()) << resumed.error().message;
    EXPECT_EQ(*resumed, *expected) << "after epoch " << epoch;
    EXPECT_TRUE(std::equal(rest.checkpoints.begin(), rest.checkpoints.end(),
                           whole.checkpoints.begin() + 1 + static_cast<std::ptrdiff_t>(epoch),
                           whole.checkpoints.end()));
  }
}

TEST_P(Demes, AStopKeepsTheBestOfTheLastWholeEpoch) {
  const EvolveConfig config = deme_config(GetParam());
  History whole;
  const auto evaluator = SerialEvaluator::make(chain_, stop_, 1).value();
  const auto expected = run(*evaluator, config, whole);
  StopFlag stop;
  const auto stopped_evaluator = SerialEvaluator::make(chain_, stop, 3).value();
  History history;
  EvolveHooks hooks = history.hooks();
  hooks.generations_done = [&, keep = hooks.generations_done](std::span<const GenerationRecord> epoch,
                                                              const Checkpoint& checkpoint) -> Result<void> {
    if (checkpoint.generation == 5) {
      stop.raise();
    }
    return keep(epoch, checkpoint);
  };
  const auto stopped = evolve(*chain_, config, *stopped_evaluator, std::nullopt, hooks);
  ASSERT_TRUE(stopped.has_value()) << stopped.error().message;
  EXPECT_TRUE(stopped->interrupted);
  EXPECT_EQ(stopped->generations_done, 6U);
  History rest;
  EXPECT_EQ(run(*evaluator, config, rest, history.checkpoints.back()).value(), *expected);
}

TEST_P(Demes, MigrantsMakeADifferenceAndWithoutThemDemesAreApart) {
  EvolveConfig config = deme_config(GetParam());
  const auto evaluator = SerialEvaluator::make(chain_, stop_, 1).value();
  History with;
  ASSERT_TRUE(run(*evaluator, config, with).has_value());
  config.ga.migrants = 0;
  History without;
  ASSERT_TRUE(run(*evaluator, config, without).has_value());
  EXPECT_EQ(with.checkpoints[0], without.checkpoints[0]) << "nobody meets before the first epoch has ended";
  EXPECT_NE(with.checkpoints[1].population, without.checkpoints[1].population);
  config.ga.epoch = 0;
  History endless;
  ASSERT_TRUE(run(*evaluator, config, endless).has_value());
  ASSERT_EQ(endless.checkpoints.size(), 1U);
  EXPECT_EQ(endless.checkpoints.back(), without.checkpoints.back());
}

TEST_P(Demes, ACheckpointThatDoesNotFitIsRefused) {
  const EvolveConfig config = deme_config(GetParam());
  const auto evaluator = SerialEvaluator::make(chain_, stop_, 1).value();
  History history;
  ASSERT_TRUE(run(*evaluator, config, history).has_value());
  const auto refused = [&](const Checkpoint& start) {
    History none;
    const auto evolved = run(*evaluator, config, none, start);
    return !evolved && evolved.error().kind == ErrorKind::bad_input;
  };
  Checkpoint amidst = history.checkpoints[1];
  amidst.generation -= 1;
  EXPECT_TRUE(refused(amidst)) << "not the end of an epoch";
  Checkpoint fewer = history.checkpoints[1];
  fewer.kept.pop_back();
  EXPECT_TRUE(refused(fewer));
  Checkpoint more = history.checkpoints[1];
  ++more.kept.front();
  EXPECT_TRUE(refused(more));
}

INSTANTIATE_TEST_SUITE_P(OfBothSearches, Demes, ::testing::Values(Search::scalar, Search::front),
                         [](const auto& search) { return std::string(name_of(search.param)); });

// A deme of no individuals, for the graph alone.
EpochResult ended(const EvolveConfig& config, const EpochTask& task) {
  EpochResult result;
  result.deme.generations = task.until;
  const std::uint32_t begin = task.deme ? task.deme->generations : 0;
  for (std::uint32_t g = begin; g < task.until; ++g) {
    result.records.emplace_back();
    result.records.back().generation = g;
  }
  for (std::uint32_t i = 0; i < config.ga.migrants; ++i) {  // who sent them, and when, as a tally
    result.emigrants.push_back({Tree(ActionId{0}), {task.number, 0, task.until, {}}});
  }
  return result;
}

TEST(DemeGraphTest, ADemeWaitsForItselfAndItsSenderAndForNobodyElse) {
  EvolveConfig config = deme_config(Search::scalar);
  config.ga.demes = 6;
  DemeGraph graph(config);
  std::vector<EpochTask> ready = graph.take_ready();
  ASSERT_EQ(ready.size(), 6U);
  EXPECT_TRUE(graph.take_ready().empty());
  // Deme 0 is slow. Those behind it in the ring go on until they need who needs it.
  std::vector<std::uint32_t> generations(6, 0);
  std::deque<EpochTask> running;
  for (EpochTask& task : ready) {
    if (task.number != 0) {
      running.push_back(std::move(task));
    }
  }
  while (!running.empty()) {
    const EpochTask task = std::move(running.front());
    running.pop_front();
    generations[task.number] = task.until;
    graph.settle(task.number, ended(config, task));
    for (EpochTask& next : graph.take_ready()) {
      EXPECT_EQ(next.migrants.size(), 2U);
      EXPECT_EQ(next.migrants.front().tally.nodes, next.number - 1) << "its neighbour in the ring";
      EXPECT_EQ(next.migrants.front().tally.steps, next.until == 11 ? 9 : next.until - 3) << "of the epoch before";
      running.push_back(std::move(next));
    }
  }
  EXPECT_EQ(generations, (std::vector<std::uint32_t>{0, 3, 6, 9, 11, 11}));
  EXPECT_FALSE(graph.take_row().has_value());
  EXPECT_EQ(graph.running(), 1U);
  graph.settle(0, ended(config, {.number = 0, .until = 3, .deme = nullptr, .migrants = {}}));
  const auto row = graph.take_row();
  ASSERT_TRUE(row.has_value());
  EXPECT_EQ(row->epoch, 0U);
  EXPECT_EQ(row->demes.size(), 6U);
  EXPECT_FALSE(graph.take_row().has_value());
}

}  // namespace
}  // namespace coppice
