// Long computations: they end, they can be stopped, and there are never too many.
#include "coordinator/studio/jobs.hpp"

#include <gtest/gtest.h>
#include <latch>

namespace coppice {
namespace {

using Json = nlohmann::ordered_json;

// Works until it is told to stop.
Result<Json> until_stopped(JobProgress& progress) {
  std::latch stopped(1);
  const StopFlag::Wake wake = progress.stop().on_raise([&] { stopped.count_down(); });
  progress.show(0.5, "half");
  progress.detail({{"generation", 3}});
  stopped.wait();
  return interrupted();
}

TEST(Jobs, AnEndedOneHasItsResult) {
  Jobs jobs;
  const auto id = jobs.start("sum", {{"tree", "move"}}, [](JobProgress&) -> Result<Json> { return Json(42); });
  ASSERT_TRUE(id);
  jobs.wait(*id);
  const auto found = jobs.find(*id);
  ASSERT_TRUE(found);
  EXPECT_EQ((*found)["state"], "done");
  EXPECT_EQ((*found)["result"], 42);
  EXPECT_EQ((*found)["about"]["tree"], "move");
  EXPECT_EQ((*found)["share"], 1.0);
  EXPECT_FALSE(jobs.list()[0].contains("result")) << "the list is asked for often";
}

TEST(Jobs, AFailureIsASentenceNotTheEndOfTheStudio) {
  Jobs jobs;
  const auto failing = jobs.start("a", nullptr, [](JobProgress&) -> Result<Json> { return failed("no disk"); });
  const auto throwing =
      jobs.start("b", nullptr, [](JobProgress&) -> Result<Json> { throw std::runtime_error("oops"); });
  jobs.wait(*failing);
  jobs.wait(*throwing);
  EXPECT_EQ((*jobs.find(*failing))["state"], "failed");
  EXPECT_EQ((*jobs.find(*failing))["error"], "no disk");
  EXPECT_EQ((*jobs.find(*throwing))["error"], "oops");
}

TEST(Jobs, AreStoppedOneByOneAndAllAtTheEnd) {
  Jobs jobs;
  const auto first = jobs.start("long", nullptr, until_stopped);
  const auto second = jobs.start("long", nullptr, until_stopped);
  EXPECT_TRUE(jobs.stop(*first));
  jobs.wait(*first);
  EXPECT_EQ((*jobs.find(*first))["state"], "stopped");
  EXPECT_FALSE(jobs.stop(*first));
  EXPECT_FALSE(jobs.stop(999));
  EXPECT_EQ((*jobs.find(*second))["state"], "running");
}  // the destructor stops the second: else this test would never end

TEST(Jobs, AreRefusedBeyondTheLimitAndForgottenWhenOld) {
  Jobs jobs;
  std::vector<std::int64_t> running;
  for (std::size_t i = 0; i < kMostJobs; ++i) {
    running.push_back(*jobs.start("long", nullptr, until_stopped));
  }
  const auto refused = jobs.start("long", nullptr, until_stopped);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("at work already"), std::string::npos);
  jobs.stop(running.front());
  jobs.wait(running.front());
  for (std::size_t i = 0; i < 2 * kMostEndedJobs; ++i) {
    const auto quick = jobs.start("quick", nullptr, [](JobProgress&) -> Result<Json> { return Json(); });
    ASSERT_TRUE(quick);
    jobs.wait(*quick);
  }
  EXPECT_LE(jobs.list().size(), kMostEndedJobs + kMostJobs);
  EXPECT_FALSE(jobs.find(running.front()));
  EXPECT_TRUE(jobs.find(running.back())) << "one that works is never forgotten";
}

}  // namespace
}  // namespace coppice
