// Serial equals remote, bit for bit, with real worker processes over real DDS on the loopback interface, whatever
// happens to the workers. Faults are injected when a batch has just gone out, so they hit in mid-generation.
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <map>
#include <memory>
#include <set>
#include <signal.h>
#include <string>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>

#include "common/cores.hpp"
#include "common/tree/text.hpp"
#include "coordinator/dispatch/serial_evaluator.hpp"
#include "coordinator/fleet/fleet_evaluator.hpp"
#include "tests/oracles/chains.hpp"
#include "tests/oracles/trees.hpp"

namespace coppice {
namespace {

using namespace std::chrono_literals;

constexpr int kMostGenerations = 2000;  // when a test evaluates until something was seen

class RemoteEvaluation : public ::testing::Test {
 protected:
  static constexpr std::size_t kTrees = 200;

  Job job(std::uint32_t generation) const {
    Job result;
    result.objectives = {{ObjectiveKind::agreement, {}},
                         {ObjectiveKind::q_value, {}},
                         {ObjectiveKind::coverage, {}},
                         {ObjectiveKind::visits, {}},
                         {ObjectiveKind::expected_return, {}}};
    result.rollouts = 20;
    result.seed = 42;
    result.generation = generation;
    return result;
  }

  std::vector<Tally> serial(std::uint32_t generation) {
    auto evaluator = SerialEvaluator::make(chain_, stop_);
    auto tallies = (*evaluator)->evaluate(trees_, job(generation));
    EXPECT_TRUE(tallies.has_value());
    return std::move(*tallies);
  }

  std::unique_ptr<FleetEvaluator> open(std::size_t workers, FleetOptions options = {}) {
    options.local_workers = workers;
    options.worker_program = COPPICE_WORKER_PROGRAM;
    options.wait_limit = 60s;
    auto evaluator = FleetEvaluator::open(chain_, options, stop_);
    EXPECT_TRUE(evaluator.has_value()) << (evaluator ? "" : evaluator.error().message);
    return std::move(*evaluator);
  }

  void expect_equal(FleetEvaluator& evaluator, std::uint32_t generation) {
    const auto tallies = evaluator.evaluate(trees_, job(generation));
    ASSERT_TRUE(tallies.has_value()) << tallies.error().message;
    EXPECT_EQ(*tallies, serial(generation)) << "generation " << generation;
  }

  StopFlag stop_;
  std::shared_ptr<const Chain> chain_ = oracles::shared_random_chain({.states = 500, .actions = 3, .seed = 7});
  std::vector<Tree> trees_ = oracles::random_trees(chain_->vocabulary(), kTrees, 11);
};

// Every thread of the process with the cores that it may use, as the kernel tells them.
std::set<std::string> cores_of_threads(pid_t pid) {
  std::set<std::string> all;
  const std::filesystem::path tasks = "/proc/" + std::to_string(pid) + "/task";
  for (const auto& task : std::filesystem::directory_iterator(tasks)) {
    std::ifstream status(task.path() / "status");
    for (std::string line; std::getline(status, line);) {
      if (line.rfind("Cpus_allowed_list:", 0) == 0) {
        all.insert(line.substr(line.find_first_not_of(" \t", line.find(':') + 1)));
      }
    }
  }
  return all;
}

TEST_F(RemoteEvaluation, WorkersThatFillTheMachineKeepToACoreEach) {
  const std::vector<int> cores = usable_cores();
  const auto evaluator = open(cores.size());
  ASSERT_TRUE(evaluator->await_workers(cores.size()));
  std::set<std::string> all;
  for (const pid_t pid : evaluator->ready_pids()) {
    const auto own = cores_of_threads(pid);
    EXPECT_EQ(own.size(), 1U) << "threads of one worker on different cores";
    all.insert(own.begin(), own.end());
  }
  std::set<std::string> expected;
  for (const int core : cores) {
    expected.insert(std::to_string(core));
  }
  EXPECT_EQ(all, expected);
  expect_equal(*evaluator, 0);
}

TEST_F(RemoteEvaluation, OtherNumbersOfWorkersRunWhereTheSystemLikes) {
  const std::vector<int> cores = usable_cores();
  const auto evaluator = open(cores.size() + 1);
  ASSERT_TRUE(evaluator->await_workers(cores.size() + 1));
  for (const pid_t pid : evaluator->ready_pids()) {
    EXPECT_EQ(cores_of_threads(pid), cores_of_threads(getpid()));
  }
}

TEST_F(RemoteEvaluation, GivesTheSerialTalliesWithOneWorker) {
  const auto evaluator = open(1);
  for (std::uint32_t generation = 0; generation < 5; ++generation) {
    expect_equal(*evaluator, generation);
  }
}

TEST_F(RemoteEvaluation, GivesTheSerialTalliesWithTwoWorkers) {
  const auto evaluator = open(2);
  for (std::uint32_t generation = 0; generation < 5; ++generation) {
    expect_equal(*evaluator, generation);
  }
}

TEST_F(RemoteEvaluation, GivesTheSerialTalliesWithFiveWorkers) {
  const auto evaluator = open(5);
  for (std::uint32_t generation = 0; generation < 5; ++generation) {
    expect_equal(*evaluator, generation);
  }
}

TEST_F(RemoteEvaluation, GivesTheSerialTalliesOfEveryMethodAndActingPolicy) {
  const auto evaluator = open(2);
  auto reference = SerialEvaluator::make(chain_, stop_);
  for (const Method method : {Method::rollouts, Method::exact, Method::discounted, Method::long_run}) {
    for (const Acting acting : {Acting::tree, Acting::policy, Acting::mixed}) {
      Job asked = job(0);
      asked.method = method;
      asked.gamma = method == Method::discounted ? fixed_point_share(0.98) : 0;
      asked.acting = acting;
      asked.policy_share = acting == Acting::mixed ? fixed_point_share(0.3) : 0;
      const auto tallies = evaluator->evaluate(trees_, asked);
      ASSERT_TRUE(tallies.has_value()) << tallies.error().message;
      EXPECT_EQ(*tallies, *(*reference)->evaluate(trees_, asked)) << name_of(method) << ", " << name_of(acting);
    }
  }
}

TEST_F(RemoteEvaluation, EvaluatesNothingWithoutAsking) {
  const auto evaluator = open(1);
  const auto tallies = evaluator->evaluate({}, job(0));
  ASSERT_TRUE(tallies.has_value());
  EXPECT_TRUE(tallies->empty());
}

TEST_F(RemoteEvaluation, GivesTheSerialTalliesWhenAnswersWouldOutgrowTheContract) {
  // One-node trees are small on the way out; six objectives make each answer larger than its question.
  trees_.assign(50'000, Tree(ActionId{1}));
  const auto evaluator = open(1);
  Job small = job(0);
  small.rollouts = 1;
  small.steps = 1;
  small.objectives.push_back({ObjectiveKind::coverage, {}});
  auto reference = SerialEvaluator::make(chain_, stop_);
  const auto tallies = evaluator->evaluate(trees_, small);
  ASSERT_TRUE(tallies.has_value()) << tallies.error().message;
  EXPECT_EQ(*tallies, *(*reference)->evaluate(trees_, small));
}

TEST_F(RemoteEvaluation, SurvivesAWorkerKilledInMidGeneration) {
  FleetOptions options;
  int batches = 0;
  std::set<pid_t> killed;
  options.batch_sent = [&](pid_t pid) {
    if (++batches == 3) {
      killed.insert(pid);
      kill(pid, SIGKILL);
    }
  };
  const auto evaluator = open(2, options);
  for (std::uint32_t generation = 0; generation < 4; ++generation) {
    expect_equal(*evaluator, generation);
  }
  EXPECT_EQ(killed.size(), 1U);
}

TEST_F(RemoteEvaluation, SurvivesEveryWorkerKilledInTheSameGeneration) {
  FleetOptions options;
  std::set<pid_t> killed;
  options.batch_sent = [&](pid_t pid) {
    if (killed.size() < 2 && killed.insert(pid).second) {
      kill(pid, SIGKILL);
    }
  };
  const auto evaluator = open(2, options);
  for (std::uint32_t generation = 0; generation < 3; ++generation) {
    expect_equal(*evaluator, generation);
  }
  EXPECT_EQ(killed.size(), 2U);
}

TEST_F(RemoteEvaluation, SurvivesAStoppedWorkerAndItsLateAnswers) {
  FleetOptions options;
  pid_t stopped = 0;
  options.batch_sent = [&](pid_t pid) {
    if (stopped == 0) {
      stopped = pid;
      kill(pid, SIGSTOP);
    }
  };
  const auto evaluator = open(2, options);
  expect_equal(*evaluator, 0);
  EXPECT_NE(stopped, 0);
  // Awake again it answers what it had: answers to slots that are settled long ago, and it comes back to work.
  kill(stopped, SIGCONT);
  bool back = false;
  bool answered_late = false;
  for (int i = 1; i < kMostGenerations && !(back && answered_late); ++i) {
    expect_equal(*evaluator, static_cast<std::uint32_t>(i));
    const auto ready = evaluator->ready_pids();
    back = std::find(ready.begin(), ready.end(), stopped) != ready.end();
    answered_late = evaluator->statistics().duplicates > 0;
  }
  EXPECT_TRUE(back);
  EXPECT_TRUE(answered_late);
}

TEST_F(RemoteEvaluation, GivesTheSerialTalliesWithPacedWorkers) {
  FleetOptions options;
  options.worker_flags = {{"--pace", "300us"}, {"--pace", "100us"}};
  const auto evaluator = open(2, options);
  for (std::uint32_t generation = 0; generation < 3; ++generation) {
    expect_equal(*evaluator, generation);
  }
}

TEST_F(RemoteEvaluation, OffersToAnotherWhatAVerySlowWorkerHolds) {
  FleetOptions options;
  options.worker_flags = {{"--pace", "600s"}, {}};  // the first answers nothing while this test lives
  const auto evaluator = open(2, options);
  ASSERT_TRUE(evaluator->await_workers(2).has_value());
  expect_equal(*evaluator, 0);
  const DispatchStatistics statistics = evaluator->statistics();
  EXPECT_GT(statistics.copies + statistics.requeued, 0U);
  EXPECT_GT(statistics.sent_bytes, 0U);
  EXPECT_GT(statistics.received_bytes, 0U);
  expect_equal(*evaluator, 1);
}

TEST_F(RemoteEvaluation, WelcomesALateWorkerOfItsOwnAccord) {
  const auto evaluator = open(1);
  expect_equal(*evaluator, 0);
  auto late = LocalWorkers::start(COPPICE_WORKER_PROGRAM, 1, evaluator->domain());
  ASSERT_TRUE(late.has_value());
  bool worked = false;
  for (int i = 1; i < kMostGenerations && !worked; ++i) {
    expect_equal(*evaluator, static_cast<std::uint32_t>(i));
    worked = evaluator->statistics().workers_alive == 2;
  }
  EXPECT_TRUE(worked);
}

TEST_F(RemoteEvaluation, GoesOnWhenAWorkerLeavesInOrder) {
  const auto evaluator = open(1);
  auto guest = LocalWorkers::start(COPPICE_WORKER_PROGRAM, 1, evaluator->domain());
  ASSERT_TRUE(guest.has_value());
  for (int i = 0; i < kMostGenerations && evaluator->statistics().workers_alive < 2; ++i) {
    expect_equal(*evaluator, static_cast<std::uint32_t>(i));
  }
  ASSERT_EQ(evaluator->statistics().workers_alive, 2U);
  const pid_t pid = guest->pids().front();
  kill(pid, SIGTERM);
  for (int i = 0; i < kMostGenerations && evaluator->statistics().workers_alive > 1; ++i) {
    expect_equal(*evaluator, static_cast<std::uint32_t>(i));
  }
  EXPECT_EQ(evaluator->statistics().workers_alive, 1U);
  EXPECT_EQ(evaluator->statistics().workers_lost, 0U);
}

// A tree at which workers die: of a size that no other has.
class DeadlyTree : public RemoteEvaluation {
 protected:
  DeadlyTree() {
    std::map<std::size_t, int> sizes;
    for (const Tree& tree : trees_) {
      ++sizes[tree.size()];
    }
    const auto deadly =
        std::find_if(trees_.begin(), trees_.end(), [&](const Tree& tree) { return sizes[tree.size()] == 1; });
    EXPECT_NE(deadly, trees_.end());
    deadly_ = *deadly;
    setenv("COPPICE_DEADLY_NODES", std::to_string(deadly_.size()).c_str(), 1);
  }
  ~DeadlyTree() override {
    unsetenv("COPPICE_DEADLY_NODES");
    unsetenv("COPPICE_DEADLY_APART");
  }

  std::unique_ptr<FleetEvaluator> open_mortal() {
    FleetOptions options;
    options.local_workers = 2;
    options.worker_program = COPPICE_MORTAL_PROGRAM;
    auto evaluator = FleetEvaluator::open(chain_, options, stop_);
    EXPECT_TRUE(evaluator.has_value()) << (evaluator ? "" : evaluator.error().message);
    return std::move(*evaluator);
  }

  Tree deadly_{ActionId{0}};
};

TEST_F(DeadlyTree, IsEvaluatedApartWhenWorkersDiedOfIt) {
  const auto evaluator = open_mortal();
  expect_equal(*evaluator, 0);
  EXPECT_EQ(evaluator->statistics().apart, 1U);
  EXPECT_GE(evaluator->statistics().suspect, 3U);
  EXPECT_GE(evaluator->statistics().workers_lost, 3U);
}

TEST_F(DeadlyTree, StopsTheRunThatNamesItWhenTheProcessApartDiesToo) {
  setenv("COPPICE_DEADLY_APART", "1", 1);
  const auto evaluator = open_mortal();
  const auto tallies = evaluator->evaluate(trees_, job(0));
  ASSERT_FALSE(tallies.has_value());
  EXPECT_EQ(tallies.error().kind, ErrorKind::failed);
  for (const std::string& part :
       {to_text(deadly_, chain_->vocabulary()), std::string("killed by signal 9"), std::string("coppice evaluate")}) {
    EXPECT_NE(tallies.error().message.find(part), std::string::npos) << part << "\n" << tallies.error().message;
  }
}

TEST_F(RemoteEvaluation, GivesUpAfterTheWaitLimitWhenNoWorkerComes) {
  FleetOptions options;
  options.wait_limit = 150ms;
  auto evaluator = FleetEvaluator::open(chain_, options, stop_);
  ASSERT_TRUE(evaluator.has_value());
  const auto tallies = (*evaluator)->evaluate(trees_, job(0));
  ASSERT_FALSE(tallies.has_value());
  EXPECT_EQ(tallies.error().kind, ErrorKind::no_worker);
  EXPECT_NE(tallies.error().message.find("no worker within"), std::string::npos) << tallies.error().message;
}

TEST_F(RemoteEvaluation, FailsWhenItsOwnWorkersCannotRun) {
  FleetOptions options;
  options.local_workers = 2;
  options.worker_program = "/bin/false";
  auto evaluator = FleetEvaluator::open(chain_, options, stop_);
  ASSERT_TRUE(evaluator.has_value());
  const auto tallies = (*evaluator)->evaluate(trees_, job(0));
  ASSERT_FALSE(tallies.has_value());
  EXPECT_NE(tallies.error().message.find("all worker processes ended"), std::string::npos) << tallies.error().message;
}

TEST_F(RemoteEvaluation, StopsWhenAsked) {
  StopFlag stop;
  FleetOptions options;
  options.local_workers = 1;
  options.worker_program = COPPICE_WORKER_PROGRAM;
  options.batch_sent = [&](pid_t) { stop.raise(); };
  auto evaluator = FleetEvaluator::open(chain_, options, stop);
  ASSERT_TRUE(evaluator.has_value());
  const auto tallies = (*evaluator)->evaluate(trees_, job(0));
  ASSERT_FALSE(tallies.has_value());
  EXPECT_EQ(tallies.error().kind, ErrorKind::interrupted);
}

TEST_F(RemoteEvaluation, RefusesADomainThatIsTaken) {
  const auto first = open(0);
  FleetOptions options;
  options.domain = first->domain();
  // Another process' domain looks like this; in one process the second join fails for the same port.
  const auto second = FleetEvaluator::open(chain_, options, stop_);
  ASSERT_FALSE(second.has_value());
  EXPECT_NE(second.error().message.find("--domain"), std::string::npos) << second.error().message;
}

TEST_F(RemoteEvaluation, RefusesAJobThatDoesNotFitTheChain) {
  const auto evaluator = open(0);
  Job bad = job(0);
  bad.objectives = {{ObjectiveKind::shaped, {}}};
  const auto tallies = evaluator->evaluate(trees_, bad);
  ASSERT_FALSE(tallies.has_value());
  EXPECT_EQ(tallies.error().kind, ErrorKind::bad_input);
}

}  // namespace
}  // namespace coppice
