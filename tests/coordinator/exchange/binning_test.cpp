#include "coordinator/exchange/binning.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

#include "common/chain/random.hpp"

namespace coppice {
namespace {

double uniform(Xoshiro256& random) { return static_cast<double>(random.next() >> 11U) * 0x1.0p-53; }

TEST(Binning, AShortNumberLiesWhereItHasTo) {
  EXPECT_EQ(short_number_between(0.0, 1.0), 0.5);
  EXPECT_EQ(short_number_between(0.0412, 0.0431), 0.042);
  EXPECT_EQ(short_number_between(-0.5, 0.5), 0.0);
  EXPECT_EQ(short_number_between(3.0, 4.0), 4.0 - 0.5);
  Xoshiro256 random(3);
  for (int trial = 0; trial < 1000; ++trial) {
    const double low = (uniform(random) - 0.5) * std::pow(10.0, static_cast<double>(random.below(20)) - 10.0);
    const double high = trial % 2 == 0 ? std::nextafter(low, 1e300) : low + uniform(random) * std::abs(low) + 1e-300;
    const double between = short_number_between(low, high);
    EXPECT_GE(between, low);
    EXPECT_LT(between, high);
  }
}

TEST(Binning, EntropyCutsWhereThePolicyChangesAndNowhereElse) {
  Xoshiro256 random(5);
  std::vector<ClassedReading> readings;
  for (int i = 0; i < 5000; ++i) {
    const double r = uniform(random) * 2.0 - 1.0;
    readings.push_back({r, static_cast<std::uint8_t>(r <= -0.25 ? 0 : r <= 0.6 ? 1 : 0), 1.0});
  }
  const std::vector<double> edges = entropy_edges(readings, 8, false);
  ASSERT_EQ(edges.size(), 2U);
  EXPECT_NEAR(edges[0], -0.25, 0.01);
  EXPECT_NEAR(edges[1], 0.6, 0.01);
  EXPECT_EQ(entropy_edges(readings, 2, false).size(), 1U);
  for (ClassedReading& reading : readings) {
    reading.action = static_cast<std::uint8_t>(random.below(2));
  }
  EXPECT_TRUE(entropy_edges(readings, 8, false).empty()) << "chance is not worth a cut";
  EXPECT_EQ(entropy_edges(readings, 8, true).size(), 1U);
  EXPECT_TRUE(entropy_edges({{1.0, 0, 1.0}, {1.0, 1, 1.0}}, 8, true).empty()) << "one reading cannot be cut";
}

TEST(Binning, QuantilesHoldAlikeManyReadings) {
  Xoshiro256 random(9);
  std::vector<ClassedReading> readings;
  for (int i = 0; i < 10'000; ++i) {
    readings.push_back({std::exp(4.0 * uniform(random)), 0, 1.0});
  }
  const std::vector<double> edges = quantile_edges(readings, 5);
  ASSERT_EQ(edges.size(), 4U);
  for (std::size_t bin = 0; bin <= edges.size(); ++bin) {
    const auto inside = std::count_if(readings.begin(), readings.end(), [&](const ClassedReading& reading) {
      return (bin == 0 || reading.reading > edges[bin - 1]) && (bin == edges.size() || reading.reading <= edges[bin]);
    });
    EXPECT_NEAR(static_cast<double>(inside), 2000.0, 60.0) << bin;
  }
  // Equal readings stay together, whatever the number of bins.
  const std::vector<double> few = quantile_edges({{1, 0, 5}, {2, 0, 1}, {1, 0, 5}, {3, 0, 1}}, 200);
  EXPECT_EQ(few.size(), 2U);
}

TEST(Binning, GivenEdgesAreSortedAndChecked) {
  EXPECT_EQ(*given_edges(std::vector<double>{3, 1, 3}), (std::vector<double>{1, 3}));
  EXPECT_FALSE(given_edges(std::vector<double>{}).has_value());
  EXPECT_FALSE(given_edges(std::vector<double>{std::nan("")}).has_value());
  std::vector<double> many(300);
  for (std::size_t i = 0; i < many.size(); ++i) {
    many[i] = static_cast<double>(i);
  }
  EXPECT_NE(given_edges(many).error().message.find("300 edges: expected 1 to 254"), std::string::npos);
}

}  // namespace
}  // namespace coppice
