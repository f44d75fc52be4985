#include "common/evolution/dominance.hpp"

#include <algorithm>
#include <bit>
#include <limits>
#include <numeric>
#include <utility>

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

namespace {

// Up to so many points every point's dominators are held as a set of bits: 2^13 points take 8 MB.
constexpr std::size_t kMostInSets = 8192;
constexpr std::size_t kBits = 64;

struct Keyed {
  double value = 0.0;
  std::uint32_t point = 0;
};

// The points by each cost, the smallest first; ties: the lower index. [costs][points]
using Orders = std::vector<std::vector<Keyed>>;

Orders orders_of(const Costs& costs) {
  Orders orders(costs.costs);
  for (std::size_t cost = 0; cost < costs.costs; ++cost) {
    std::vector<Keyed>& order = orders[cost];
    order.reserve(costs.points());
    for (std::uint32_t point = 0; point < costs.points(); ++point) {
      order.push_back({costs.of(point)[cost], point});
    }
    std::sort(order.begin(), order.end(), [](const Keyed& a, const Keyed& b) {
      return a.value != b.value ? a.value < b.value : a.point < b.point;
    });
  }
  return orders;
}

// Which points are at least as good in everything, itself among them, as one bit each: for every cost, those that come
// no later in its order. [points x words]
std::vector<std::uint64_t> as_good_as(const Orders& orders, std::size_t points, std::size_t words) {
  std::vector<std::uint64_t> sets(points * words, ~std::uint64_t{0});
  std::vector<std::uint64_t> so_far(words);
  for (const std::vector<Keyed>& order : orders) {
    std::fill(so_far.begin(), so_far.end(), 0);
    for (std::size_t begin = 0; begin < points;) {
      std::size_t end = begin;
      for (; end < points && order[end].value == order[begin].value; ++end) {
        so_far[order[end].point / kBits] |= std::uint64_t{1} << (order[end].point % kBits);
      }
      for (; begin < end; ++begin) {
        std::uint64_t* const set = sets.data() + order[begin].point * words;
        for (std::size_t w = 0; w < words; ++w) {
          set[w] &= so_far[w];
        }
      }
    }
  }
  return sets;
}

// A point's set holds that of whoever dominates it, and itself besides: by the size of their sets, all who dominate a
// point come before it, and those of its own size do not dominate it.
std::vector<std::uint32_t> ranks_by_sets(const Orders& orders, std::size_t points) {
  const std::size_t words = (points + kBits - 1) / kBits;
  const std::vector<std::uint64_t> sets = as_good_as(orders, points, words);
  struct Sized {
    std::uint32_t size = 0;
    std::uint32_t point = 0;
  };
  std::vector<Sized> by_size;
  by_size.reserve(points);
  for (std::uint32_t point = 0; point < points; ++point) {
    std::uint32_t size = 0;
    for (std::size_t w = 0; w < words; ++w) {
      size += static_cast<std::uint32_t>(std::popcount(sets[point * words + w]));
    }
    by_size.push_back({size, point});
  }
  std::sort(by_size.begin(), by_size.end(),
            [](const Sized& a, const Sized& b) { return a.size != b.size ? a.size < b.size : a.point < b.point; });
  std::vector<std::uint32_t> ranks(points);
  std::vector<std::vector<std::uint64_t>> fronts;
  const auto meets = [&](std::uint32_t point, const std::vector<std::uint64_t>& front) {
    for (std::size_t w = 0; w < words; ++w) {
      if ((sets[point * words + w] & front[w]) != 0) {
        return true;
      }
    }
    return false;
  };
  for (std::size_t begin = 0; begin < points;) {
    std::size_t end = begin;
    for (; end < points && by_size[end].size == by_size[begin].size; ++end) {
      const std::uint32_t point = by_size[end].point;
      while (ranks[point] < fronts.size() && meets(point, fronts[ranks[point]])) {
        ++ranks[point];
      }
    }
    for (; begin < end; ++begin) {
      const std::uint32_t point = by_size[begin].point;
      if (ranks[point] == fronts.size()) {
        fronts.emplace_back(words, 0);
      }
      fronts[ranks[point]][point / kBits] |= std::uint64_t{1} << (point % kBits);
    }
  }
  return ranks;
}

std::vector<std::uint32_t> ranks_one_by_one(const Costs& costs) {
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

std::vector<double> crowding_by(const Orders& orders, std::span<const std::uint32_t> ranks) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  std::vector<double> crowding(ranks.size(), 0.0);
  std::vector<std::size_t> first;  // of each rank among points by rank
  for (const std::uint32_t rank : ranks) {
    first.resize(std::max<std::size_t>(first.size(), rank + 2), 0);
    ++first[rank + 1];
  }
  std::partial_sum(first.begin(), first.end(), first.begin());
  std::vector<Keyed> by_rank(ranks.size());  // then by the cost
  std::vector<std::size_t> next;
  for (const std::vector<Keyed>& order : orders) {
    next = first;
    for (const Keyed& keyed : order) {
      by_rank[next[ranks[keyed.point]]++] = keyed;
    }
    for (std::size_t rank = 0; rank + 1 < first.size(); ++rank) {
      const std::span<const Keyed> group = std::span(by_rank).subspan(first[rank], first[rank + 1] - first[rank]);
      if (group.empty()) {
        continue;
      }
      const double range = group.back().value - group.front().value;
      crowding[group.front().point] = kInfinity;
      crowding[group.back().point] = kInfinity;
      for (std::size_t i = 1; i + 1 < group.size() && range > 0.0; ++i) {
        crowding[group[i].point] += (group[i + 1].value - group[i - 1].value) / range;
      }
    }
  }
  return crowding;
}

}  // namespace

std::vector<std::uint32_t> ranks_of(const Costs& costs) { return standing_of(costs).ranks; }

std::vector<double> crowding_of(const Costs& costs, std::span<const std::uint32_t> ranks) {
  COPPICE_CHECK(ranks.size() == costs.points());
  return crowding_by(orders_of(costs), ranks);
}

namespace {

std::vector<std::uint32_t> ranks_by(const Orders& orders, const Costs& costs) {
  return costs.points() > kMostInSets ? ranks_one_by_one(costs) : ranks_by_sets(orders, costs.points());
}

// The orders of the kept points alone, renumbered. REQUIRES: ascending.
void keep_in(Orders& orders, std::span<const std::size_t> kept, std::size_t points) {
  constexpr std::uint32_t kGone = ~std::uint32_t{0};
  std::vector<std::uint32_t> renumbered(points, kGone);
  for (std::size_t i = 0; i < kept.size(); ++i) {
    renumbered[kept[i]] = static_cast<std::uint32_t>(i);
  }
  for (std::vector<Keyed>& order : orders) {
    std::size_t end = 0;
    for (const Keyed& keyed : order) {
      if (renumbered[keyed.point] != kGone) {
        order[end++] = {keyed.value, renumbered[keyed.point]};
      }
    }
    order.resize(end);
  }
}

Survivors survivors_by(Orders orders, std::vector<std::uint32_t> ranks, std::size_t count) {
  const std::vector<double> crowding = crowding_by(orders, ranks);
  Survivors result;
  std::vector<std::size_t>& kept = result.points;
  kept.resize(ranks.size());
  std::iota(kept.begin(), kept.end(), std::size_t{0});
  std::nth_element(kept.begin(), kept.begin() + static_cast<std::ptrdiff_t>(count), kept.end(),
                   [&](std::size_t a, std::size_t b) {
                     return ranks[a] != ranks[b]         ? ranks[a] < ranks[b]
                            : crowding[a] != crowding[b] ? crowding[a] > crowding[b]
                                                         : a < b;
                   });
  kept.resize(count);
  std::sort(kept.begin(), kept.end());
  // Whoever is of a lower rank than a survivor is one, too: the ranks are the same without the others.
  keep_in(orders, kept, ranks.size());
  result.standing.ranks.reserve(count);
  for (const std::size_t point : kept) {
    result.standing.ranks.push_back(ranks[point]);
  }
  result.standing.crowding = crowding_by(orders, result.standing.ranks);
  return result;
}

}  // namespace

Standing standing_of(const Costs& costs) {
  const Orders orders = orders_of(costs);
  Standing standing;
  standing.ranks = ranks_by(orders, costs);
  standing.crowding = crowding_by(orders, standing.ranks);
  return standing;
}

Survivors survivors_of(const Costs& costs, std::size_t count) {
  COPPICE_CHECK(count <= costs.points());
  Orders orders = orders_of(costs);
  std::vector<std::uint32_t> ranks = ranks_by(orders, costs);
  return survivors_by(std::move(orders), std::move(ranks), count);
}

Survivors survivors_of_front(const Costs& costs, std::size_t count) {
  COPPICE_CHECK(count <= costs.points());
  return survivors_by(orders_of(costs), std::vector<std::uint32_t>(costs.points(), 0), count);
}

}  // namespace coppice
