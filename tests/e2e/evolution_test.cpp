// The main promise: an evolution over worker processes ends with the trees and statistics of the serial one, bit for
// bit, for any number of workers and any fault. Every generation's population and fitness are compared, not only the
// end.
#include <algorithm>
#include <gtest/gtest.h>
#include <memory>
#include <set>
#include <signal.h>
#include <thread>
#include <vector>

#include "coordinator/dispatch/serial_evaluator.hpp"
#include "coordinator/evolution/evolve.hpp"
#include "coordinator/fleet/evaluator_pool.hpp"
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

class EvolutionOverWorkers : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    LearnSettings settings = default_settings(WorldKind::uav, Algorithm::q_learning);
    settings.episodes = 2000;
    const auto world = load_world("uav");
    auto learned = learn(*world, settings, {});
    ASSERT_TRUE(learned.has_value());
    chain_ = std::make_shared<const Chain>(std::move(learned->chain));
    StopFlag stop;
    auto evaluator = SerialEvaluator::make(chain_, stop);
    expected_ = std::make_unique<Course>(run(**evaluator));
    ASSERT_EQ(expected_->records.size(), config().ga.generations);
  }

  static void TearDownTestSuite() {
    chain_.reset();
    expected_.reset();
  }

  static EvolveConfig config() {
    EvolveConfig result;
    result.seed = 77;
    result.ga.generations = 40;
    result.fitness.coverage = 0.5;
    return result;
  }

  static Course run(Evaluator& evaluator, const std::function<void(std::uint32_t)>& after_generation = {}) {
    Course course;
    EvolveHooks hooks;
    hooks.generations_done = [&](std::span<const GenerationRecord> records,
                                 const Checkpoint& checkpoint) -> Result<void> {
      course.records.push_back(records.back());
      course.records.back().seconds = 0.0;  // the only field that may differ
      course.checkpoints.push_back(checkpoint);
      if (after_generation) {
        after_generation(records.back().generation);
      }
      return {};
    };
    auto evolved = evolve(*chain_, config(), evaluator, std::nullopt, hooks);
    EXPECT_TRUE(evolved.has_value()) << evolved.error().message;
    course.evolved = std::move(*evolved);
    return course;
  }

  std::unique_ptr<FleetEvaluator> open(std::size_t workers, std::function<void(pid_t)> batch_sent = {}) {
    FleetOptions options;
    options.local_workers = workers;
    options.worker_program = COPPICE_WORKER_PROGRAM;
    options.batch_sent = std::move(batch_sent);
    auto evaluator = FleetEvaluator::open(chain_, options, stop_);
    EXPECT_TRUE(evaluator.has_value()) << evaluator.error().message;
    return std::move(*evaluator);
  }

  void expect_serial_course(const Course& course) { EXPECT_TRUE(course == *expected_); }

  static inline std::shared_ptr<const Chain> chain_;
  static inline std::unique_ptr<Course> expected_;
  StopFlag stop_;
};

TEST_F(EvolutionOverWorkers, IsTheSerialOneWithOneWorker) { expect_serial_course(run(*open(1))); }

TEST_F(EvolutionOverWorkers, IsTheSerialOneWithTwoWorkers) { expect_serial_course(run(*open(2))); }

TEST_F(EvolutionOverWorkers, IsTheSerialOneWithFiveWorkers) { expect_serial_course(run(*open(5))); }

TEST_F(EvolutionOverWorkers, IsTheSerialOneWithAWorkerKilledInMidGeneration) {
  int batches = 0;
  bool killed = false;
  const auto evaluator = open(2, [&](pid_t pid) {
    if (++batches == 15) {
      kill(pid, SIGKILL);
      killed = true;
    }
  });
  expect_serial_course(run(*evaluator));
  EXPECT_TRUE(killed);
  // Noticed by its lease, unless the other worker did all the rest before that ran out.
  EXPECT_LE(evaluator->statistics().workers_lost, 1U);
}

TEST_F(EvolutionOverWorkers, IsTheSerialOneWithAWorkerStoppedInMidGeneration) {
  int batches = 0;
  pid_t stopped = 0;
  const auto evaluator = open(2, [&](pid_t pid) {
    if (++batches == 15) {
      stopped = pid;
      kill(pid, SIGSTOP);
    }
  });
  expect_serial_course(run(*evaluator));
  ASSERT_NE(stopped, 0);
  kill(stopped, SIGCONT);
}

TEST_F(EvolutionOverWorkers, IsTheSerialOneWithDuplicatedAnswers) {
  // A stopped worker's batch is evaluated elsewhere; woken when the generation is done, it answers too. Again until
  // that was seen: a worker may be stopped just after its answer left.
  int batches = 0;
  pid_t stopped = 0;
  FleetEvaluator* watched = nullptr;
  const auto evaluator = open(2, [&](pid_t pid) {
    if (++batches % 6 == 5 && stopped == 0 && watched->statistics().duplicates == 0) {
      stopped = pid;
      kill(pid, SIGSTOP);
    }
  });
  watched = evaluator.get();
  const Course course = run(*evaluator, [&](std::uint32_t) {
    if (stopped != 0) {
      kill(stopped, SIGCONT);
      stopped = 0;
    }
  });
  expect_serial_course(course);
  EXPECT_GE(evaluator->statistics().duplicates, 1U);
}

TEST_F(EvolutionOverWorkers, IsTheSerialOneWithAWorkerThatJoinsLate) {
  const auto evaluator = open(1);
  std::optional<LocalWorkers> late;
  const Course course = run(*evaluator, [&](std::uint32_t generation) {
    if (generation == 10) {
      auto started = LocalWorkers::start(COPPICE_WORKER_PROGRAM, 1, evaluator->domain());
      ASSERT_TRUE(started.has_value());
      late.emplace(std::move(*started));
    }
  });
  EXPECT_TRUE(late.has_value());
  expect_serial_course(course);
}

// Several at once on one set of workers, one of which is killed.
TEST_F(EvolutionOverWorkers, IsTheSerialOneForEveryRunOfAPool) {
  FleetOptions options;
  options.local_workers = 2;
  options.worker_program = COPPICE_WORKER_PROGRAM;
  int batches = 0;
  options.batch_sent = [&](pid_t pid) {
    if (++batches == 40) {
      kill(pid, SIGKILL);
    }
  };
  auto pool = EvaluatorPool::open(chain_, options, stop_);
  ASSERT_TRUE(pool.has_value()) << pool.error().message;
  constexpr std::size_t kRuns = 5;
  std::vector<Course> courses(kRuns);
  std::vector<std::thread> threads;
  for (Course& course : courses) {
    threads.emplace_back([&] {
      const auto evaluator = (*pool)->client();
      course = run(*evaluator);
    });
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
  EXPECT_GT(batches, 40);
  for (const Course& course : courses) {
    expect_serial_course(course);
  }
}

TEST_F(EvolutionOverWorkers, EndsEveryRunOfAPoolThatIsToldToStop) {
  FleetOptions options;
  options.local_workers = 1;
  options.worker_program = COPPICE_WORKER_PROGRAM;
  auto pool = EvaluatorPool::open(chain_, options, stop_);
  ASSERT_TRUE(pool.has_value()) << pool.error().message;
  std::vector<std::thread> threads;
  for (int i = 0; i < 3; ++i) {
    threads.emplace_back([&] {
      EvolveConfig endless = config();
      endless.ga.generations = kMaxGenerations;
      EvolveHooks hooks;
      hooks.generations_done = [&](std::span<const GenerationRecord> records, const Checkpoint&) -> Result<void> {
        if (records.back().generation == 3) {
          stop_.raise();
        }
        return {};
      };
      const auto evaluator = (*pool)->client();
      const auto evolved = evolve(*chain_, endless, *evaluator, std::nullopt, hooks);
      EXPECT_TRUE(evolved ? evolved->interrupted : evolved.error().kind == ErrorKind::interrupted);
    });
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
}

}  // namespace
}  // namespace coppice
