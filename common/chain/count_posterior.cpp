#include "common/chain/count_posterior.hpp"

#include <algorithm>
#include <cmath>

#include "common/check.hpp"

namespace coppice {

double CountPosterior::uniform() { return (static_cast<double>(random_.next() >> 11U) + 0.5) * 0x1.0p-53; }

// Box and Muller (1958); the second variate is not kept, so that a draw depends on nothing before it but the generator.
double CountPosterior::normal() {
  constexpr double kTwoPi = 6.283185307179586;
  const double radius = std::sqrt(-2.0 * std::log(uniform()));
  return radius * std::cos(kTwoPi * uniform());
}

double CountPosterior::gamma(double shape) {
  COPPICE_CHECK(shape >= 1.0);
  const double d = shape - 1.0 / 3.0;
  const double c = 1.0 / std::sqrt(9.0 * d);
  while (true) {  // accepts more than 95 % of its turns, whatever the shape
    const double x = normal();
    const double cube = 1.0 + c * x;
    if (cube <= 0.0) {
      continue;
    }
    const double v = cube * cube * cube;
    if (std::log(uniform()) < 0.5 * x * x + d - d * v + d * std::log(v)) {
      return d * v;
    }
  }
}

void CountPosterior::draw(std::span<const std::size_t> rows, std::span<double> probabilities) {
  COPPICE_CHECK(probabilities.size() == chain_.transitions());
  for (const std::size_t row : rows) {
    const auto counts = chain_.counts(row);
    COPPICE_CHECK(!counts.empty());
    const auto of_row = probabilities.subspan(chain_.parts().row_begin[row], counts.size());
    double sum = 0.0;
    for (std::size_t i = 0; i < counts.size(); ++i) {
      of_row[i] = counts.size() == 1 ? 1.0 : gamma(static_cast<double>(counts[i]));
      sum += of_row[i];
    }
    for (double& probability : of_row) {
      probability /= sum;
    }
  }
}

double missing_mass(const Chain& chain, std::size_t row) {
  const auto counts = chain.counts(row);
  const auto once = std::count(counts.begin(), counts.end(), 1U);
  return static_cast<double>(once) / static_cast<double>(chain.tries(row));
}

}  // namespace coppice
