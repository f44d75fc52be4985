#include "coordinator/evolution/dominance.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

#include "common/check.hpp"

namespace coppice {

bool dominates(std::span<const double> a, std::span<const double> b) {
  bool better = false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a[i] > b[i]) {
      return false;
    }
    better = better || a[i] < b[i];
  }
  return better;
}

std::vector<std::uint32_t> ranks_of(const Costs& costs) {
  std::vector<std::size_t> order(costs.points());
  std::iota(order.begin(), order.end(), std::size_t{0});
  // What comes later in this order dominates nothing before it.
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    const auto of_a = costs.of(a);
    const auto of_b = costs.of(b);
    return std::lexicographical_compare(of_a.begin(), of_a.end(), of_b.begin(), of_b.end());
  });
  std::vector<std::uint32_t> ranks(costs.points());
  std::vector<std::vector<std::size_t>> fronts;
  for (const std::size_t point : order) {
    // The latest of a front are the likeliest to dominate.
    const auto front = std::find_if(fronts.begin(), fronts.end(), [&](const std::vector<std::size_t>& members) {
      return std::none_of(members.rbegin(), members.rend(),
                          [&](std::size_t member) { return dominates(costs.of(member), costs.of(point)); });
    });
    ranks[point] = static_cast<std::uint32_t>(front - fronts.begin());
    if (front == fronts.end()) {
      fronts.push_back({point});
    } else {
      front->push_back(point);
    }
  }
  return ranks;
}

std::vector<double> crowding_of(const Costs& costs, std::span<const std::uint32_t> ranks) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  COPPICE_CHECK(ranks.size() == costs.points());
  std::vector<double> crowding(ranks.size(), 0.0);
  std::vector<std::size_t> order(ranks.size());
  for (std::size_t cost = 0; cost < costs.costs; ++cost) {
    std::iota(order.begin(), order.end(), std::size_t{0});
    const auto at = [&](std::size_t point) { return costs.of(point)[cost]; };
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return ranks[a] != ranks[b] ? ranks[a] < ranks[b] : at(a) < at(b);
    });
    for (std::size_t begin = 0; begin < order.size();) {
      std::size_t last = begin;  // of the rank
      while (last + 1 < order.size() && ranks[order[last + 1]] == ranks[order[begin]]) {
        ++last;
      }
      const double range = at(order[last]) - at(order[begin]);
      crowding[order[begin]] = kInfinity;
      crowding[order[last]] = kInfinity;
      for (std::size_t i = begin + 1; i < last && range > 0.0; ++i) {
        crowding[order[i]] += (at(order[i + 1]) - at(order[i - 1])) / range;
      }
      begin = last + 1;
    }
  }
  return crowding;
}

std::vector<std::size_t> survivors(const Costs& costs, std::size_t count) {
  COPPICE_CHECK(count <= costs.points());
  const std::vector<std::uint32_t> ranks = ranks_of(costs);
  const std::vector<double> crowding = crowding_of(costs, ranks);
  std::vector<std::size_t> order(costs.points());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return ranks[a] != ranks[b] ? ranks[a] < ranks[b] : crowding[a] > crowding[b];
  });
  order.resize(count);
  return order;
}

}  // namespace coppice
