#include "coordinator/dispatch/measured_pace.hpp"

#include <gtest/gtest.h>

namespace coppice {
namespace {

using namespace std::chrono_literals;

WorkClass of_size(std::uint64_t size) { return {WorkKind::evaluate, size}; }

TEST(MeasuredPace, KeepsEveryClassOfWorkApart) {
  MeasuredPace pace;
  EXPECT_EQ(pace.each(of_size(500)), 0ns);
  pace.add(20ms, 10, of_size(500));
  EXPECT_EQ(pace.each(of_size(500)), 2ms);
  EXPECT_EQ(pace.each(of_size(501)), 0ns);
  pace.add(50ms, 10, of_size(50'000));
  EXPECT_EQ(pace.each(of_size(50'000)), 5ms);
  EXPECT_EQ(pace.each(of_size(500)), 2ms);
}

TEST(MeasuredPace, RemembersTheLastClassesOnly) {
  MeasuredPace pace;
  for (std::uint64_t steps = 1; steps <= 100; ++steps) {
    pace.add(1ms, 1, of_size(steps));
  }
  EXPECT_EQ(pace.each(of_size(1)), 0ns);
  EXPECT_EQ(pace.each(of_size(100)), 1ms);
  EXPECT_EQ(pace.each(of_size(100 - MeasuredPace::kClasses + 1)), 1ms);
}

TEST(MeasuredPace, WeighsAnswersByTheirUnits) {
  MeasuredPace pace;
  pace.add(10ms, 1, of_size(500));  // held up
  pace.add(99us, 99, of_size(500));
  EXPECT_EQ(pace.each(of_size(500)), 100'990ns);
}

TEST(MeasuredPace, FollowsAWorkerThatChanges) {
  MeasuredPace pace;
  pace.add(1s, 1000, of_size(500));
  for (int batch = 0; batch < 10; ++batch) {
    pace.add(500ms, 50, of_size(500));  // ten times slower
  }
  EXPECT_GT(pace.each(of_size(500)), 9900us);
  EXPECT_LE(pace.each(of_size(500)), 10ms);
}

TEST(MeasuredPace, DoubtsWhatNothingConfirms) {
  MeasuredPace pace;
  std::chrono::steady_clock::time_point now{};
  pace.doubt(now);
  pace.add(1s, 1, of_size(500));
  now += MeasuredPace::kDoubtEvery * 1s;
  pace.doubt(now);
  EXPECT_EQ(pace.each(of_size(500)), 1s);
  for (int generation = 0; generation < 20; ++generation) {
    now += MeasuredPace::kDoubtEvery * 1s;
    pace.doubt(now);
  }
  EXPECT_LT(pace.each(of_size(500)), 1ms);
  EXPECT_GT(pace.each(of_size(500)), 0ns);
}

TEST(MeasuredPace, DoubtsNoFasterThanUnitsTake) {
  MeasuredPace pace;
  std::chrono::steady_clock::time_point now{};
  pace.add(1s, 1, of_size(500));
  now += MeasuredPace::kDoubtEvery * 1s;
  pace.doubt(now);  // confirmed by the answer
  for (int request = 0; request < 500; ++request) {
    now += 10ms;
    pace.doubt(now);
  }
  EXPECT_EQ(pace.each(of_size(500)), 700ms);
  pace.add(2s, 1, of_size(500));
  EXPECT_EQ(pace.each(of_size(500)), 2s);
}

}  // namespace
}  // namespace coppice
