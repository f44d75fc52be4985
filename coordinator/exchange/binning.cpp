#include "coordinator/exchange/binning.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fmt/format.h>

#include "common/check.hpp"
#include "common/tree/vocabulary.hpp"

namespace coppice {
namespace {

void sort_readings(std::vector<ClassedReading>& readings) {
  std::sort(readings.begin(), readings.end(), [](const ClassedReading& a, const ClassedReading& b) {
    return a.reading != b.reading ? a.reading < b.reading : a.action < b.action;
  });
}

constexpr std::size_t kMoved = 500;          // one reading in so many may change sides for a shorter edge
constexpr std::size_t kManyReadings = 5000;  // from here on

// A short edge near the cut before readings[at]. REQUIRES: sorted; readings[at - 1] differs from readings[at].
double edge_at(const std::vector<ClassedReading>& readings, std::size_t at) {
  const std::size_t moved = readings.size() < kManyReadings ? 0 : readings.size() / kMoved;
  const std::size_t low = at - 1 - std::min(moved, at - 1);
  const std::size_t high = std::min(at + moved, readings.size() - 1);
  return short_number_between(readings[low].reading, readings[high].reading);
}

using Weights = std::array<double, 256>;  // of the actions

double total(const Weights& weights) {
  double sum = 0.0;
  for (const double weight : weights) {
    sum += weight;
  }
  return sum;
}

// In bits.
double entropy(const Weights& weights, double sum) {
  double bits = 0.0;
  for (const double weight : weights) {
    if (weight > 0.0) {
      bits -= weight / sum * std::log2(weight / sum);
    }
  }
  return bits;
}

double classes(const Weights& weights) {
  return static_cast<double>(std::count_if(weights.begin(), weights.end(), [](double w) { return w > 0.0; }));
}

struct Part {
  std::size_t begin = 0;
  std::size_t end = 0;
};

struct Cut {
  std::size_t at = 0;  // the first reading of the upper part
  double edge = 0.0;
  double gained = 0.0;  // information gain x weight of the part: what the cut saves in all
  bool worth = false;
};

class Cutter {
 public:
  explicit Cutter(const std::vector<ClassedReading>& readings) : readings_(readings) {}

  // The best cut of a part; `gained` 0: there is none.
  Cut best(const Part& part) const {
    Weights above{};
    for (std::size_t i = part.begin; i < part.end; ++i) {
      above[readings_[i].action] += readings_[i].weight;
    }
    const Weights all = above;
    const double sum = total(all);
    const double before = entropy(all, sum);
    Weights below{};
    double below_sum = 0.0;
    Cut best;
    double least = before;
    Weights best_below{};
    for (std::size_t i = part.begin; i + 1 < part.end; ++i) {
      below[readings_[i].action] += readings_[i].weight;
      below_sum += readings_[i].weight;
      above[readings_[i].action] = std::max(0.0, above[readings_[i].action] - readings_[i].weight);
      // An optimal cut lies where the action changes (Fayyad and Irani, theorem 1), and only between distinct readings.
      if (readings_[i].reading == readings_[i + 1].reading) {
        continue;
      }
      const double above_sum = std::max(sum - below_sum, 1e-300);
      const double left = below_sum / sum * entropy(below, below_sum) + above_sum / sum * entropy(above, total(above));
      if (left < least - 1e-12) {
        least = left;
        best.at = i + 1;
        best_below = below;
      }
    }
    if (best.at == 0) {
      return best;
    }
    best.edge = edge_at(readings_, best.at);
    best.gained = (before - least) * sum;
    Weights best_above{};
    for (std::size_t c = 0; c < all.size(); ++c) {
      best_above[c] = all[c] - best_below[c] > 1e-9 * sum ? all[c] - best_below[c] : 0.0;
    }
    const double k = classes(all);
    const double delta =
        std::log2(std::pow(3.0, k) - 2.0) - (k * before - classes(best_below) * entropy(best_below, total(best_below)) -
                                             classes(best_above) * entropy(best_above, total(best_above)));
    const auto count = static_cast<double>(part.end - part.begin);
    best.worth = before - least > (std::log2(count - 1.0) + delta) / count;
    return best;
  }

 private:
  const std::vector<ClassedReading>& readings_;
};

}  // namespace

double short_number_between(double low, double high) {
  COPPICE_CHECK(low < high);
  const double middle = low / 2.0 + high / 2.0;
  constexpr int kDigits = 17;
  for (int digits = 1; digits <= kDigits; ++digits) {
    std::array<char, 64> text{};
    static_cast<void>(std::snprintf(text.data(), text.size(), "%.*g", digits, middle));
    const double number = std::strtod(text.data(), nullptr);
    if (number >= low && number < high) {
      return number == 0.0 ? 0.0 : number;  // never -0
    }
  }
  return low;
}

std::vector<double> quantile_edges(std::vector<ClassedReading> readings, std::size_t bins) {
  sort_readings(readings);
  double sum = 0.0;
  for (const ClassedReading& reading : readings) {
    sum += reading.weight;
  }
  std::vector<double> edges;
  double below = 0.0;
  std::size_t wanted = 1;
  for (std::size_t i = 0; i + 1 < readings.size() && wanted < bins; ++i) {
    below += readings[i].weight;
    if (readings[i].reading == readings[i + 1].reading) {
      continue;
    }
    if (below >= sum * static_cast<double>(wanted) / static_cast<double>(bins)) {
      edges.push_back(edge_at(readings, i + 1));
      while (wanted < bins && below >= sum * static_cast<double>(wanted) / static_cast<double>(bins)) {
        ++wanted;
      }
    }
  }
  // Two cuts may share a short edge.
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

std::vector<double> entropy_edges(std::vector<ClassedReading> readings, std::size_t bins, bool at_least_one) {
  sort_readings(readings);
  if (readings.size() < 2) {
    return {};
  }
  const Cutter cutter(readings);
  std::vector<Part> open{{0, readings.size()}};
  std::vector<Cut> cuts;
  while (!open.empty() && cuts.size() < kMaxValues) {  // ends: every turn takes a part away or cuts it
    const Part part = open.back();
    open.pop_back();
    const Cut cut = cutter.best(part);
    const bool first = part.begin == 0 && part.end == readings.size();
    if (cut.at == 0 || !(cut.worth || (first && at_least_one))) {
      continue;
    }
    cuts.push_back(cut);
    open.push_back({part.begin, cut.at});
    open.push_back({cut.at, part.end});
  }
  std::stable_sort(cuts.begin(), cuts.end(), [](const Cut& a, const Cut& b) { return a.gained > b.gained; });
  cuts.resize(std::min(cuts.size(), bins - 1));
  std::vector<double> edges;
  edges.reserve(cuts.size());
  for (const Cut& cut : cuts) {
    edges.push_back(cut.edge);
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

Result<std::vector<double>> given_edges(std::span<const double> edges) {
  std::vector<double> sorted(edges.begin(), edges.end());
  if (std::any_of(sorted.begin(), sorted.end(), [](double edge) { return !std::isfinite(edge); })) {
    return bad_input("an edge of a bin is not a finite number");
  }
  std::sort(sorted.begin(), sorted.end());
  sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
  if (sorted.empty() || sorted.size() > kMaxValues - 1) {
    return bad_input(fmt::format("{} edges: expected 1 to {}", sorted.size(), kMaxValues - 1));
  }
  return sorted;
}

}  // namespace coppice
