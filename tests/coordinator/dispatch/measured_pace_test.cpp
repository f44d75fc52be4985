#include "coordinator/dispatch/measured_pace.hpp"

#include <gtest/gtest.h>

namespace coppice {
namespace {

using namespace std::chrono_literals;

TEST(MeasuredPace, KeepsJobsOfEverySizeApart) {
  MeasuredPace pace;
  EXPECT_EQ(pace.each(500), 0ns);
  pace.add(20ms, 10, 500);
  EXPECT_EQ(pace.each(500), 2ms);
  EXPECT_EQ(pace.each(501), 0ns);
  pace.add(50ms, 10, 50'000);
  EXPECT_EQ(pace.each(50'000), 5ms);
  EXPECT_EQ(pace.each(500), 2ms);
}

TEST(MeasuredPace, RemembersTheLastSizesOnly) {
  MeasuredPace pace;
  for (std::uint64_t steps = 1; steps <= 100; ++steps) {
    pace.add(1ms, 1, steps);
  }
  EXPECT_EQ(pace.each(1), 0ns);
  EXPECT_EQ(pace.each(100), 1ms);
  EXPECT_EQ(pace.each(100 - MeasuredPace::kSizes + 1), 1ms);
}

TEST(MeasuredPace, WeighsAnswersByTheirIndividuals) {
  MeasuredPace pace;
  pace.add(10ms, 1, 500);  // held up
  pace.add(99us, 99, 500);
  EXPECT_EQ(pace.each(500), 100'990ns);
}

TEST(MeasuredPace, FollowsAWorkerThatChanges) {
  MeasuredPace pace;
  pace.add(1s, 1000, 500);
  for (int batch = 0; batch < 10; ++batch) {
    pace.add(500ms, 50, 500);  // ten times slower
  }
  EXPECT_GT(pace.each(500), 9900us);
  EXPECT_LE(pace.each(500), 10ms);
}

TEST(MeasuredPace, DoubtsWhatNothingConfirms) {
  MeasuredPace pace;
  pace.begin_generation();
  pace.add(1s, 1, 500);
  pace.begin_generation();
  EXPECT_EQ(pace.each(500), 1s);
  for (int generation = 0; generation < 20; ++generation) {
    pace.begin_generation();
  }
  EXPECT_LT(pace.each(500), 1ms);
  EXPECT_GT(pace.each(500), 0ns);
}

}  // namespace
}  // namespace coppice
