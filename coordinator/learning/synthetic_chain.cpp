#include "coordinator/learning/synthetic_chain.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <numeric>
#include <string>
#include <vector>

#include "common/chain/random.hpp"

namespace coppice {
namespace {

constexpr std::uint32_t kMostValues = 64;  // of a feature
constexpr std::uint32_t kMostCount = 1000;
constexpr std::uint32_t kNeighbourhood = 256;  // states around one, where half of its successors are
constexpr double kLargestReward = 8.0;         // the UAV's for a piece of trash

// values^features, or `enough` if that is less.
std::uint64_t distinct_states(std::uint32_t values, std::uint32_t features, std::uint64_t enough) {
  std::uint64_t count = 1;
  for (std::uint32_t f = 0; f < features && count < enough; ++f) {
    count *= values;
  }
  return std::min(count, enough);
}

Result<std::uint32_t> values_needed(const SyntheticShape& shape) {
  for (std::uint32_t values = 2; values <= kMostValues; ++values) {
    if (distinct_states(values, shape.features, shape.states) >= shape.states) {
      return values;
    }
  }
  return bad_input(fmt::format("--features {}: cannot tell {} states apart with {} values each: expected more",
                               shape.features, shape.states, kMostValues));
}

Result<void> check_shape(const SyntheticShape& shape) {
  const auto check = [](const char* flag, std::uint64_t found, std::uint64_t least,
                        std::uint64_t most) -> Result<void> {
    if (found < least || found > most) {
      return bad_input(fmt::format("{} {}: expected {} to {}", flag, found, least, most));
    }
    return {};
  };
  auto ok = check("--states", shape.states, 1, kMaxStates);
  ok = ok ? check("--actions", shape.actions, 1, kMaxActions) : ok;
  ok = ok ? check("--branching", shape.branching, 1, shape.states) : ok;
  ok = ok ? check("--features", shape.features, 1, kMaxFeatures) : ok;
  const std::uint64_t transitions = std::uint64_t{shape.states} * shape.actions * shape.branching;
  if (ok && transitions > kMaxTransitions) {
    return bad_input(fmt::format("--states x --actions x --branching make {} transitions: expected at most {}",
                                 transitions, kMaxTransitions));
  }
  return ok;
}

// Different for every state: the state's number, spread over the digits by a factor that shares none with the base.
void put_features(const SyntheticShape& shape, std::uint32_t values, ChainParts& parts) {
  const std::uint64_t space = distinct_states(values, shape.features, std::uint64_t{1} << 32U);
  std::uint64_t spread = 2'654'435'761U % space;
  while (std::gcd(spread, space) != 1) {
    ++spread;
  }
  parts.features.reserve(std::size_t{shape.states} * shape.features);
  for (std::uint64_t state = 0; state < shape.states; ++state) {
    std::uint64_t digits = static_cast<std::uint64_t>(static_cast<Uint128>(state) * spread % space);
    for (std::uint32_t f = 0; f < shape.features; ++f, digits /= values) {
      parts.features.push_back(static_cast<std::uint8_t>(digits % values));
    }
  }
}

void put_row(const SyntheticShape& shape, std::uint32_t state, Xoshiro256& random, std::vector<std::uint32_t>& row,
             ChainParts& parts) {
  const std::uint32_t near = std::max(shape.branching, std::min(kNeighbourhood, shape.states));
  row.clear();
  while (row.size() < shape.branching) {
    for (std::size_t missing = shape.branching - row.size(); missing > 0; --missing) {
      const bool is_near = (random.next() & 1U) != 0;
      row.push_back(static_cast<std::uint32_t>(is_near ? (state + random.below(near)) % shape.states
                                                       : random.below(shape.states)));
    }
    std::sort(row.begin(), row.end());
    row.erase(std::unique(row.begin(), row.end()), row.end());
  }
  double tries = 0.0;
  for (const std::uint32_t successor : row) {
    // Small counts are common, large ones rare, as where one outcome dominates.
    const auto count = static_cast<std::uint32_t>(1 + random.below(1 + random.below(kMostCount)));
    parts.successor.push_back(successor);
    parts.count.push_back(count);
    tries += count;
  }
  const double mean = kLargestReward * (static_cast<double>(random.below(2001)) / 1000.0 - 1.0);
  parts.reward_sum.push_back(mean * tries);
  parts.q.push_back(mean);
  parts.visits.back() += static_cast<std::uint64_t>(tries);
  parts.row_begin.push_back(parts.successor.size());
}

}  // namespace

Result<Chain> synthetic_chain(const SyntheticShape& shape) {
  if (auto ok = check_shape(shape); !ok) {
    return tl::unexpected(ok.error());
  }
  const auto values = values_needed(shape);
  if (!values) {
    return tl::unexpected(values.error());
  }
  ChainParts parts;
  Feature feature;
  feature.admits_equal = true;
  feature.admits_less_equal = true;
  feature.values.resize(*values);
  std::iota(feature.values.begin(), feature.values.end(), std::uint8_t{0});
  for (std::uint32_t f = 0; f < shape.features; ++f) {
    feature.name = fmt::format("f{}", f);
    parts.vocabulary.features.push_back(feature);
  }
  for (std::uint32_t action = 0; action < shape.actions; ++action) {
    parts.vocabulary.actions.push_back(fmt::format("a{}", action));
  }
  put_features(shape, *values, parts);
  const std::size_t rows = std::size_t{shape.states} * shape.actions;
  parts.row_begin.reserve(rows + 1);
  parts.row_begin.push_back(0);
  parts.successor.reserve(rows * shape.branching);
  parts.count.reserve(rows * shape.branching);
  parts.reward_sum.reserve(rows);
  parts.q.reserve(rows);
  parts.visits.reserve(shape.states);
  Xoshiro256 random(shape.seed);
  std::vector<std::uint32_t> row;
  for (std::uint32_t state = 0; state < shape.states; ++state) {
    parts.visits.push_back(0);
    for (std::uint32_t action = 0; action < shape.actions; ++action) {
      put_row(shape, state, random, row, parts);
    }
  }
  parts.policy = greedy_policy(parts.q, shape.actions);
  return Chain::make(std::move(parts));
}

}  // namespace coppice
