#include "coordinator/sweep/summary.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "common/check.hpp"

namespace coppice {

const std::vector<SweepColumn>& sweep_columns(bool simulated) {
  static const std::vector<SweepColumn> on_chain = {
      {"coverage", "all states %", 100.0, 1, true}, {"agreement", "on chain %", 100.0, 1, true},
      {"fitness", "fitness", 1.0, 3, true},         {"nodes", "nodes", 1.0, 1, false},
      {"distinct", "distinct %", 100.0, 1, true},   {"meanings", "meanings %", 100.0, 1, true},
      {"seconds", "seconds", 1.0, 2, false},
  };
  static const std::vector<SweepColumn> all = [] {
    std::vector<SweepColumn> extended = on_chain;
    extended.push_back({"simulated_agreement", "simulated %", 100.0, 1, true});
    extended.push_back({"reward", "reward", 1.0, 1, true});
    extended.push_back({"collisions", "collisions", 1.0, 2, false});
    return extended;
  }();
  return simulated ? all : on_chain;
}

double value_of(const SweepResult& result, std::size_t measure) {
  switch (measure) {
    case 0:
      return result.coverage;
    case 1:
      return result.agreement;
    case 2:
      return result.fitness;
    case 3:
      return static_cast<double>(result.nodes);
    case 4:
      return result.distinct;
    case 5:
      return result.meanings;
    case 6:
      return result.seconds;
    default:
      break;
  }
  COPPICE_CHECK(result.simulated.has_value() && measure < 10);
  return measure == 7   ? result.simulated->agreement
         : measure == 8 ? result.simulated->reward
                        : result.simulated->collisions;
}

double student_t(std::size_t degrees) {
  COPPICE_CHECK(degrees >= 1);
  constexpr std::array<double, 30> kSmall = {12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228,
                                             2.201,  2.179, 2.160, 2.145, 2.131, 2.120, 2.110, 2.101, 2.093, 2.086,
                                             2.080,  2.074, 2.069, 2.064, 2.060, 2.056, 2.052, 2.048, 2.045, 2.042};
  if (degrees <= kSmall.size()) {
    return kSmall[degrees - 1];
  }
  return degrees < 40 ? 2.042 : degrees < 60 ? 2.021 : degrees < 120 ? 2.000 : 1.980;
}

Summary summary_of(std::vector<double> values) {
  COPPICE_CHECK(!values.empty());
  std::sort(values.begin(), values.end());
  const auto count = static_cast<double>(values.size());
  Summary summary{.runs = values.size(), .low = values.front(), .high = values.back()};
  summary.mean = std::accumulate(values.begin(), values.end(), 0.0) / count;
  const std::size_t middle = values.size() / 2;
  summary.median = values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
  if (values.size() > 1) {
    double squares = 0.0;
    for (const double value : values) {
      squares += (value - summary.mean) * (value - summary.mean);
    }
    summary.deviation = std::sqrt(squares / (count - 1.0));
    summary.margin = student_t(values.size() - 1) * summary.deviation / std::sqrt(count);
  }
  return summary;
}

}  // namespace coppice
