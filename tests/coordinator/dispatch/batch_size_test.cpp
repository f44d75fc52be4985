#include "coordinator/dispatch/batch_size.hpp"

#include <gtest/gtest.h>

namespace coppice {
namespace {

using namespace std::chrono_literals;

FleetPace alike(std::size_t lanes, std::chrono::nanoseconds each) {
  FleetPace fleet;
  for (std::size_t i = 0; i < lanes; ++i) {
    fleet.add({1, each}, 0ns);
  }
  return fleet;
}

BatchRequest request(std::uint32_t waiting, const FleetPace& fleet, const WorkerPace& worker) {
  return {.waiting = waiting,
          .end = fleet.known() ? fleet.end(waiting) : 0.0,
          .fastest = fleet.fastest(),
          .worker = worker,
          .remaining = 0ns};
}

std::uint32_t size(std::uint32_t waiting, std::size_t lanes, std::chrono::nanoseconds each) {
  return batch_size(request(waiting, alike(lanes, each), {1, each}));
}

TEST(BatchSize, SharesAGenerationAmongTheLanes) {
  EXPECT_EQ(size(200, 2, 1ms), 50U);    // 50 ms is the longest
  EXPECT_EQ(size(100, 2, 100us), 43U);  // 0.85 of a share: guided
  EXPECT_EQ(size(100, 2, 1us), 51U);    // not worth splitting further
  EXPECT_EQ(size(1, 64, 1us), 1U);
  EXPECT_EQ(size(100, 2, 10s), 1U);
}

TEST(BatchSize, ShrinksAsTheGenerationEmpties) {
  std::uint32_t waiting = 1000;
  std::uint32_t last = waiting;
  while (waiting > 0) {
    const std::uint32_t next = size(waiting, 4, 100us);
    ASSERT_GE(next, 1U);
    ASSERT_LE(next, waiting);
    EXPECT_LE(next, last);
    last = next;
    waiting -= next;
  }
}

TEST(BatchSize, TriesAWorkerThatWasNeverMeasuredWithOne) {
  EXPECT_EQ(batch_size(request(100, alike(2, 10us), {1, 0ns})), 1U);
  EXPECT_EQ(size(100, 2, 0ns), 1U);
}

TEST(BatchSize, GivesByPace) {
  FleetPace fleet = alike(19, 2ms);
  fleet.add({1, 20ms}, 0ns);
  EXPECT_EQ(batch_size(request(400, fleet, {1, 2ms})), 18U);  // 0.85 of 42 ms
  EXPECT_EQ(batch_size(request(400, fleet, {1, 20ms})), 2U);
}

TEST(BatchSize, GivesNothingThatTheOthersWillHaveDoneBefore) {
  FleetPace fleet = alike(2, 1ms);
  fleet.add({1, 20ms}, 0ns);
  EXPECT_EQ(batch_size(request(10, fleet, {1, 20ms})), 0U);
  BatchRequest more = request(100, fleet, {1, 20ms});
  EXPECT_EQ(batch_size(more), 2U);
  more.remaining = 31ms;
  EXPECT_EQ(batch_size(more), 0U);
}

TEST(BatchSize, GivesTheFastestIdleWorkerSomethingAlways) {
  for (std::uint32_t waiting = 1; waiting < 200; ++waiting) {
    for (const std::int64_t each : {1, 7, 3000, 333000, 5000000, 2000000000}) {
      EXPECT_GE(size(waiting, 3, std::chrono::nanoseconds(each)), 1U) << waiting << " of " << each << " ns";
    }
  }
}

TEST(FleetPace, CountsWhatItsWorkersAreAt) {
  FleetPace fleet = alike(2, 1ms);
  EXPECT_DOUBLE_EQ(fleet.end(10), 5e6);
  fleet.add({2, 2ms}, 6ms);
  EXPECT_DOUBLE_EQ(fleet.end(12), 6e6);  // 12 and 6 more, by 3 a millisecond
}

TEST(FleetPace, TakesLanesThatWereNotMeasuredForAverageOnes) {
  FleetPace fleet;
  fleet.add({2, 1ms}, 0ns);
  EXPECT_DOUBLE_EQ(fleet.end(10), 5e6);
  fleet.add({2, 0ns}, 0ns);
  EXPECT_DOUBLE_EQ(fleet.end(10), 2.5e6);
  EXPECT_DOUBLE_EQ(fleet.fastest(), 1e6);
}

}  // namespace
}  // namespace coppice
