// The runs of a setting as a few numbers: for each measure the mean, its 95 % confidence interval by Student's t, the
// sample standard deviation (n - 1), the median, the lowest and the highest.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "coordinator/sweep/sweep.hpp"

namespace coppice {

struct SweepColumn {
  std::string name;          // a column of runs.csv
  std::string title;         // for a table, with its unit
  double scale = 1.0;        // of the value, for a table
  int decimals = 1;          // likewise
  bool high_is_good = true;  // which end is the best
};

// What there is to know about a run of a plan; simulated ones only if there are episodes.
const std::vector<SweepColumn>& sweep_columns(bool simulated);
// The value of sweep_columns(simulated)[measure]. REQUIRES: the result has it.
double value_of(const SweepResult& result, std::size_t measure);

struct Summary {
  std::size_t runs = 0;
  double mean = 0.0;
  double margin = 0.0;  // half the interval's width; 0 for one run
  double deviation = 0.0;
  double median = 0.0;
  double low = 0.0;
  double high = 0.0;
};

// REQUIRES: values not empty.
Summary summary_of(std::vector<double> values);

// The 97.5 % quantile of Student's t (Abramowitz & Stegun 1964, table 26.10; between its rows the larger value).
// REQUIRES: degrees >= 1.
double student_t(std::size_t degrees);

}  // namespace coppice
