#include "common/fitness/golden_job.hpp"

#include <gtest/gtest.h>

namespace coppice {
namespace {

TEST(GoldenJob, GivesTheSameWithVectorsAndWithoutAndAtEveryCall) {
  EXPECT_NE(golden_checksum(), 0U);
  EXPECT_EQ(compute_golden_checksum(Simd::none), golden_checksum());
  EXPECT_EQ(compute_golden_checksum(best_simd()), golden_checksum());
}

}  // namespace
}  // namespace coppice
