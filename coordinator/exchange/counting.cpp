#include "coordinator/exchange/counting.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/check.hpp"

namespace coppice {
namespace {

constexpr std::uint32_t kMostDenominator = 10'000;
constexpr double kPrinted = 1e-10;

// 0: none up to kMostDenominator.
std::uint32_t common_denominator(std::span<const double> probabilities) {
  for (std::uint32_t d = 1; d <= kMostDenominator; ++d) {
    std::uint64_t sum = 0;
    const bool fits = std::all_of(probabilities.begin(), probabilities.end(), [&](double p) {
      const double share = p * d;
      const double whole = std::round(share);
      sum += static_cast<std::uint64_t>(whole);
      return whole >= 1.0 && std::abs(share - whole) <= kPrinted * d;
    });
    if (fits && sum == d) {
      return d;
    }
  }
  return 0;
}

}  // namespace

std::vector<std::uint32_t> counts_of(std::span<const double> probabilities) {
  COPPICE_CHECK(!probabilities.empty());
  const std::uint32_t denominator = common_denominator(probabilities);
  const std::uint32_t all = denominator == 0 ? kMostCounts : kMostCounts / denominator * denominator;
  std::vector<std::uint32_t> counts;
  counts.reserve(probabilities.size());
  if (denominator != 0) {
    for (const double p : probabilities) {
      counts.push_back(static_cast<std::uint32_t>(std::llround(p * denominator)) * (all / denominator));
    }
    return counts;
  }
  std::vector<double> fraction;
  std::uint64_t given = 0;
  for (const double p : probabilities) {
    const double share = p * all;
    counts.push_back(static_cast<std::uint32_t>(share));
    fraction.push_back(share - std::floor(share));
    given += counts.back();
  }
  std::vector<std::uint32_t> order(counts.size());
  std::iota(order.begin(), order.end(), 0U);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return fraction[a] > fraction[b]; });
  // What is left is less than one for each entry, but for the rounding of the sum of all.
  for (std::size_t i = 0; given < all; i = (i + 1) % order.size()) {
    ++counts[order[i]];
    ++given;
  }
  for (std::size_t i = order.size(); given > all; i = i == 0 ? order.size() : i) {
    --i;
    if (counts[order[i]] > 0) {
      --counts[order[i]];
      --given;
    }
  }
  return counts;
}

}  // namespace coppice
