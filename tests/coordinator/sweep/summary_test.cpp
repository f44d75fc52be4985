#include "coordinator/sweep/summary.hpp"

#include <cmath>
#include <gtest/gtest.h>

namespace coppice {
namespace {

TEST(Summary, IsThatOfATextbookSample) {
  const Summary summary = summary_of({4.0, 2.0, 6.0, 8.0});
  EXPECT_EQ(summary.runs, 4U);
  EXPECT_DOUBLE_EQ(summary.mean, 5.0);
  EXPECT_DOUBLE_EQ(summary.median, 5.0);
  EXPECT_DOUBLE_EQ(summary.deviation, std::sqrt(20.0 / 3.0));
  EXPECT_DOUBLE_EQ(summary.margin, 3.182 * std::sqrt(20.0 / 3.0) / 2.0);
  EXPECT_DOUBLE_EQ(summary.low, 2.0);
  EXPECT_DOUBLE_EQ(summary.high, 8.0);
}

TEST(Summary, OfOneRunHasNoInterval) {
  const Summary summary = summary_of({3.0});
  EXPECT_DOUBLE_EQ(summary.median, 3.0);
  EXPECT_DOUBLE_EQ(summary.margin, 0.0);
}

TEST(Summary, StudentsTFallsTowardsTheNormalQuantile) {
  for (std::size_t degrees = 1; degrees < 500; ++degrees) {
    EXPECT_GE(student_t(degrees), student_t(degrees + 1));
    EXPECT_GT(student_t(degrees), 1.959);
  }
  EXPECT_DOUBLE_EQ(student_t(9), 2.262);
}

}  // namespace
}  // namespace coppice
