// Whoever does not belong changes nothing: damaged and foreign samples are counted and dropped, and a worker of
// another protocol version is refused with a message on both sides.
#include <csignal>
#include <fmt/format.h>
#include <functional>
#include <gtest/gtest.h>
#include <memory>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>
#include <sstream>
#include <unistd.h>

#include "coordinator/dispatch/serial_evaluator.hpp"
#include "coordinator/fleet/fleet_evaluator.hpp"
#include "tests/e2e/process.hpp"
#include "tests/oracles/chains.hpp"
#include "tests/oracles/trees.hpp"

namespace coppice {
namespace {

constexpr std::uint32_t kMostGenerations = 100'000;  // while the stranger lives; each takes under a millisecond

class Strangers : public ::testing::Test {
 protected:
  void SetUp() override {
    spdlog::set_default_logger(
        std::make_shared<spdlog::logger>("test", std::make_shared<spdlog::sinks::ostream_sink_mt>(log_)));
  }

  std::unique_ptr<FleetEvaluator> open(const std::vector<LocalWorkers::Flags>& worker_flags = {}) {
    FleetOptions options;
    options.local_workers = 1;
    options.worker_flags = worker_flags;
    options.worker_program = COPPICE_WORKER_PROGRAM;
    auto evaluator = FleetEvaluator::open(chain_, options, stop_);
    EXPECT_TRUE(evaluator.has_value()) << evaluator.error().message;
    return std::move(*evaluator);
  }

  void expect_serial_tallies(FleetEvaluator& evaluator, std::uint32_t generation) {
    Job job;
    job.generation = generation;
    auto serial = SerialEvaluator::make(chain_, stop_);
    const auto expected = (*serial)->evaluate(trees_, job);
    const auto tallies = evaluator.evaluate(trees_, job);
    ASSERT_TRUE(tallies.has_value()) << tallies.error().message;
    ASSERT_EQ(*tallies, *expected);
  }

  void expect_serial_tallies_while(FleetEvaluator& evaluator, e2e::Process& stranger) {
    for (std::uint32_t generation = 1; generation < kMostGenerations && stranger.running(); ++generation) {
      expect_serial_tallies(evaluator, generation);
    }
  }

  // What has arrived may take a while to be read: the test goes on until it was.
  void expect_serial_tallies_until(FleetEvaluator& evaluator, const std::function<bool()>& seen) {
    for (std::uint32_t generation = 0; generation < kMostGenerations && !seen(); ++generation) {
      expect_serial_tallies(evaluator, generation);
    }
    EXPECT_TRUE(seen()) << log_.str();
  }

  e2e::Process stranger(const FleetEvaluator& evaluator, const std::string& mode,
                        const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments = {std::to_string(evaluator.domain()), mode};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return e2e::Process({.program = COPPICE_STRANGER, .arguments = arguments});
  }

  std::ostringstream log_;
  StopFlag stop_;
  std::shared_ptr<const Chain> chain_ = oracles::shared_random_chain({.states = 100, .seed = 9});
  std::vector<Tree> trees_ = oracles::random_trees(chain_->vocabulary(), 60, 5);
};

TEST_F(Strangers, WhoTalkNonsenseAreCountedAndDropped) {
  const auto evaluator = open();
  expect_serial_tallies(*evaluator, 0);
  e2e::Process noise = stranger(*evaluator, "noise");
  expect_serial_tallies_while(*evaluator, noise);
  EXPECT_EQ(noise.wait(), (e2e::Ending{0, 0})) << noise.rest_of_error();
  expect_serial_tallies_until(*evaluator, [&] { return evaluator->statistics().rejected > 50; });
  EXPECT_EQ(log_.str().find('\x1b'), std::string::npos) << log_.str();
  EXPECT_NE(log_.str().find("dropped a sample"), std::string::npos) << log_.str();
}

TEST_F(Strangers, WhoSpeakInAWorkersNameAreNotTakenForIt) {
  const auto evaluator = open();
  expect_serial_tallies(*evaluator, 0);
  e2e::Process forger = stranger(*evaluator, "forge");
  expect_serial_tallies_while(*evaluator, forger);
  EXPECT_EQ(forger.wait(), (e2e::Ending{0, 0})) << forger.rest_of_error();
  expect_serial_tallies_until(*evaluator, [&] { return evaluator->statistics().rejected > 1000; });
  EXPECT_EQ(evaluator->statistics().workers_lost, 0U) << log_.str();
  EXPECT_EQ(evaluator->statistics().requeued, 0U);
  EXPECT_NE(log_.str().find("from somebody else"), std::string::npos) << log_.str();
}

TEST_F(Strangers, WhoDisposeOfWorkersTakeNoneAway) {
  for (const char* const way : {"dispose", "unregister", "vanish", "steal"}) {
    const auto evaluator = open();
    expect_serial_tallies(*evaluator, 0);
    e2e::Process attacker = stranger(*evaluator, way);
    expect_serial_tallies_while(*evaluator, attacker);
    EXPECT_EQ(attacker.wait(), (e2e::Ending{0, 0})) << way << ": " << attacker.rest_of_error();
    expect_serial_tallies(*evaluator, kMostGenerations);
    EXPECT_EQ(evaluator->statistics().workers_lost, 0U) << way << "\n" << log_.str();
    EXPECT_EQ(evaluator->statistics().requeued, 0U) << way;
    EXPECT_EQ(evaluator->statistics().workers_alive, 1U) << way;
  }
}

TEST_F(Strangers, WhoSpeakAnotherProtocolVersionAreRefusedWithAMessageOnBothSides) {
  const auto evaluator = open();
  expect_serial_tallies(*evaluator, 0);
  e2e::Process next = stranger(*evaluator, "next");
  expect_serial_tallies_while(*evaluator, next);
  EXPECT_EQ(next.wait(), (e2e::Ending{1, 0}));
  const std::string said = next.rest_of_error();
  const std::uint32_t ours = wire::kProtocolVersion;
  EXPECT_NE(said.find(fmt::format("speaks protocol {}, this worker (version 99.0) speaks {}", ours, ours + 1)),
            std::string::npos)
      << said;
  EXPECT_NE(log_.str().find(fmt::format("it speaks protocol {}, this coordinator", ours + 1)), std::string::npos)
      << log_.str();
  EXPECT_EQ(evaluator->statistics().workers_alive, 1U);
}

TEST_F(Strangers, WhoComputeOtherwiseAreRefusedWithAMessageOnBothSides) {
  const auto evaluator = open();
  expect_serial_tallies(*evaluator, 0);
  e2e::Process other = stranger(*evaluator, "build");
  expect_serial_tallies_while(*evaluator, other);
  EXPECT_EQ(other.wait(), (e2e::Ending{1, 0}));
  const std::string said = other.rest_of_error();
  EXPECT_NE(said.find("computes otherwise than this worker (version 99.0)"), std::string::npos) << said;
  EXPECT_NE(said.find("install the same build of Coppice on both"), std::string::npos) << said;
  EXPECT_NE(log_.str().find("it computes otherwise than this coordinator"), std::string::npos) << log_.str();
  EXPECT_EQ(evaluator->statistics().workers_alive, 1U);
}

// A stranger who reaches the worker's own port announces runs that the worker must refuse, and disposes of what the
// coordinator announced.
TEST_F(Strangers, WhoPlayTheCoordinatorOfAnotherVersionStopNoWorker) {
  constexpr int kFirstPort = 30'000;
  constexpr int kPorts = 2'000;
  const std::string port = std::to_string(kFirstPort + getpid() % kPorts);
  const auto evaluator = open({{"--port", port}});
  expect_serial_tallies(*evaluator, 0);
  e2e::Process misleader = stranger(*evaluator, "mislead", {"-", port});
  expect_serial_tallies_while(*evaluator, misleader);
  EXPECT_EQ(misleader.wait(), (e2e::Ending{0, 0})) << misleader.rest_of_error();
  expect_serial_tallies(*evaluator, kMostGenerations);
  EXPECT_EQ(evaluator->statistics().workers_lost, 0U) << log_.str();
  EXPECT_EQ(evaluator->statistics().requeued, 0U) << log_.str();
  EXPECT_EQ(evaluator->statistics().workers_alive, 1U);
}

// 2^22 steps of 32 lanes' draws take more memory than the worker gets, so it gives every such batch back and lives on.
TEST_F(Strangers, AWorkerWithoutMemoryForABatchGivesItBackAndGoesOn) {
  const auto evaluator = open();
  expect_serial_tallies(*evaluator, 0);
  e2e::Process starved({.program = COPPICE_STARVED, .arguments = {std::to_string(evaluator->domain())}});
  ASSERT_TRUE(evaluator->await_workers(2).has_value());
  Job job;
  job.rollouts = 32;
  job.steps = std::uint32_t{1} << 17U;
  const std::span<const Tree> some(trees_.data(), 6);
  const auto expected = (*SerialEvaluator::make(chain_, stop_))->evaluate(some, job);
  for (std::uint32_t generation = 1; generation < kMostGenerations && evaluator->statistics().requeued == 0;
       ++generation) {
    const auto tallies = evaluator->evaluate(some, job);
    ASSERT_TRUE(tallies.has_value()) << tallies.error().message;
    ASSERT_EQ(*tallies, *expected);
  }
  EXPECT_GT(evaluator->statistics().requeued, 0U);
  EXPECT_EQ(evaluator->statistics().workers_alive, 2U);
  expect_serial_tallies(*evaluator, 1);
  starved.signal(SIGTERM);
  EXPECT_EQ(starved.wait(), (e2e::Ending{0, 0}));
  EXPECT_NE(starved.rest_of_output().find("not enough memory"), std::string::npos);  // where its log goes
}

}  // namespace
}  // namespace coppice
