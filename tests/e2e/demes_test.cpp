// Demes end on worker processes as they do on threads here, bit for bit: for any number of workers, several lanes in
// one, workers that are killed or stopped in the middle of an epoch, and a run that is taken up elsewhere.
#include <algorithm>
#include <gtest/gtest.h>
#include <memory>
#include <signal.h>
#include <vector>

#include "coordinator/dispatch/serial_evaluator.hpp"
#include "coordinator/evolution/evolve.hpp"
#include "coordinator/fleet/fleet_evaluator.hpp"
#include "coordinator/learning/learn.hpp"

namespace coppice {
namespace {

struct Course {
  Evolved evolved;
  std::vector<GenerationRecord> records;
  std::vector<Checkpoint> checkpoints;
  bool operator==(const Course&) const = default;
};

EvolveConfig config_of(Search search) {
  EvolveConfig config;
  config.seed = 77;
  config.ga.search = search;
  config.ga.generations = 40;
  config.ga.population = 90;
  config.ga.demes = 6;
  config.ga.epoch = 6;
  config.ga.migrants = 2;
  config.fitness.coverage = 0.5;
  if (search == Search::front) {
    config.ga.max_nodes = 20;
    config.ga.edits = 0.5;
    config.ga.local_search = 0.3;
    config.front.members = 40;
  }
  return config;
}

class DemesOverWorkers : public ::testing::TestWithParam<Search> {
 protected:
  static void SetUpTestSuite() {
    LearnSettings settings = default_settings(WorldKind::uav, Algorithm::q_learning);
    settings.episodes = 2000;
    const auto world = load_world("uav");
    auto learned = learn(*world, settings, {});
    ASSERT_TRUE(learned.has_value());
    chain_ = std::make_shared<const Chain>(std::move(learned->chain));
  }
  static void TearDownTestSuite() { chain_.reset(); }

  Course run(Evaluator& evaluator, std::optional<Checkpoint> start = std::nullopt) {
    Course course;
    EvolveHooks hooks;
    hooks.generations_done = [&](std::span<const GenerationRecord> records,
                                 const Checkpoint& checkpoint) -> Result<void> {
      for (const GenerationRecord& record : records) {
        course.records.push_back(record);
        course.records.back().seconds = 0.0;  // the only field that may differ
      }
      course.checkpoints.push_back(checkpoint);
      return {};
    };
    auto evolved = evolve(*chain_, config_, evaluator, std::move(start), hooks);
    EXPECT_TRUE(evolved.has_value()) << evolved.error().message;
    course.evolved = std::move(*evolved);
    return course;
  }

  Course expected() {
    auto evaluator = SerialEvaluator::make(chain_, stop_, 2);
    return run(**evaluator);
  }

  std::unique_ptr<FleetEvaluator> open(FleetOptions options) {
    options.worker_program = COPPICE_WORKER_PROGRAM;
    auto evaluator = FleetEvaluator::open(chain_, std::move(options), stop_);
    EXPECT_TRUE(evaluator.has_value()) << evaluator.error().message;
    return std::move(*evaluator);
  }

  static inline std::shared_ptr<const Chain> chain_;
  EvolveConfig config_ = config_of(GetParam());
  StopFlag stop_;
};

TEST_P(DemesOverWorkers, EndAsHereWithAnyNumberOfWorkersAndLanes) {
  const Course here = expected();
  for (const std::size_t workers : {1U, 2U, 5U}) {
    FleetOptions options;
    options.local_workers = workers;
    EXPECT_TRUE(run(*open(std::move(options))) == here) << workers << " workers";
  }
  FleetOptions options;
  options.local_workers = 1;
  options.worker_threads = 3;
  EXPECT_TRUE(run(*open(std::move(options))) == here) << "one worker of three lanes";
}

TEST_P(DemesOverWorkers, EndAsHereWhenWorkersAreKilledAndStopped) {
  const Course here = expected();
  for (const int signal : {SIGKILL, SIGSTOP}) {
    int sent = 0;
    pid_t hit = 0;
    FleetOptions options;
    options.local_workers = 3;
    options.batch_sent = [&](pid_t pid) {
      if (++sent == 9) {
        hit = pid;
        kill(pid, signal);
      }
    };
    const auto evaluator = open(std::move(options));
    EXPECT_TRUE(run(*evaluator) == here);
    EXPECT_NE(hit, 0);
    if (signal == SIGSTOP) {
      kill(hit, SIGCONT);
    }
  }
}

TEST_P(DemesOverWorkers, EndAsHereWhenEveryEpochIsCheckedHere) {
  FleetOptions options;
  options.local_workers = 2;
  options.cross_check = 1.0;
  const auto evaluator = open(std::move(options));
  EXPECT_TRUE(run(*evaluator) == expected());
  EXPECT_GE(evaluator->statistics().cross_checked, 6U * 7U) << "six demes, seven epochs";
}

TEST_P(DemesOverWorkers, GoOnOverWorkersFromWhereTheyStoodHereAndTheReverse) {
  const Course here = expected();
  FleetOptions options;
  options.local_workers = 2;
  const auto workers = open(std::move(options));
  const auto threads = SerialEvaluator::make(chain_, stop_, 2).value();
  for (const std::size_t epoch : {std::size_t{0}, std::size_t{3}}) {
    for (Evaluator* const evaluator : {static_cast<Evaluator*>(workers.get()), threads.get()}) {
      const Course rest = run(*evaluator, here.checkpoints[epoch]);
      EXPECT_EQ(rest.evolved, here.evolved);
      EXPECT_TRUE(std::equal(rest.checkpoints.begin(), rest.checkpoints.end(),
                             here.checkpoints.begin() + 1 + static_cast<std::ptrdiff_t>(epoch),
                             here.checkpoints.end()));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(OfBothSearches, DemesOverWorkers, ::testing::Values(Search::scalar, Search::front),
                         [](const auto& search) { return std::string(name_of(search.param)); });

}  // namespace
}  // namespace coppice
