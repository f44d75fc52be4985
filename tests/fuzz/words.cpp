#include "tests/fuzz/words.hpp"

#include <string>
#include <utility>
#include <vector>

#include "common/chain/random.hpp"
#include "common/check.hpp"
#include "common/tree/tick.hpp"

namespace coppice::fuzz {

const Vocabulary& words() {
  static const Vocabulary vocabulary = [] {
    Vocabulary result;
    for (const char* sensor : {"s0", "s1", "s2", "s3", "s4", "s5", "s6", "s7"}) {
      result.features.push_back({sensor, {0, 1, 3}, true, false});
    }
    result.features.push_back({"x", {0, 1, 2, 3, 4, 5, 6, 7, 8, 9}, true, true});
    result.features.push_back({"y", {0, 10, 100, 255}, false, true});
    result.actions = {"move", "turn_left", "turn_right"};
    COPPICE_CHECK(check_vocabulary(result).has_value());
    return result;
  }();
  return vocabulary;
}

Chain small_chain() {
  constexpr std::uint32_t kStates = 12;
  Xoshiro256 random(1);
  ChainParts parts;
  parts.vocabulary = words();
  parts.row_begin = {0};
  for (std::uint32_t state = 0; state < kStates; ++state) {
    for (const Feature& feature : parts.vocabulary.features) {
      parts.features.push_back(feature.name == "x" ? static_cast<std::uint8_t>(state % 10)
                                                   : feature.values[random.below(feature.values.size())]);
    }
    parts.visits.push_back(random.below(1000));
    for (std::size_t action = 0; action < parts.vocabulary.actions.size(); ++action) {
      const bool tried = random.below(5) > 0;
      for (std::uint32_t next = state % 3; tried && next < kStates; next += 3) {
        parts.successor.push_back(next);
        parts.count.push_back(static_cast<std::uint32_t>(1 + random.below(100)));
      }
      parts.row_begin.push_back(parts.successor.size());
      parts.reward_sum.push_back(tried ? static_cast<double>(random.below(2000)) / 100.0 - 10.0 : 0.0);
      parts.q.push_back(static_cast<double>(random.below(4000)) / 100.0 - 20.0);
    }
  }
  parts.policy = greedy_policy(parts.q, parts.vocabulary.actions.size());
  parts.initial_state = 1;
  auto chain = Chain::make(std::move(parts));
  COPPICE_CHECK(chain.has_value());
  return std::move(*chain);
}

Chain full_chain() {
  constexpr std::uint32_t kEnd = 11;
  ChainParts parts = small_chain().parts();
  Feature& x = parts.vocabulary.features[8];
  x.scale = Scale::numbers;
  x.numbers = {-9.5, -7, -5, -3, -1, 0, 0.25, 100, 1e6, 1e100};
  Feature& y = parts.vocabulary.features[9];
  y.scale = Scale::bins;
  y.numbers = {-0.0419, 0.0, 0.0419};
  parts.starts = {{1, 3}, {5, 1}, {8, 2}};
  parts.no_action = {NoAction::Kind::named, ActionId{2}};
  parts.look_alikes = true;
  parts.terminals = {kEnd};
  const std::size_t actions = parts.vocabulary.actions.size();
  // The end is the last state: its rows are the last ones.
  parts.successor.resize(parts.row_begin[kEnd * actions]);
  parts.count.resize(parts.successor.size());
  for (std::size_t row = kEnd * actions; row < (kEnd + 1) * actions; ++row) {
    parts.successor.push_back(kEnd);
    parts.count.push_back(1);
    parts.row_begin[row + 1] = parts.successor.size();
    parts.reward_sum[row] = 0.0;
  }
  for (std::size_t row = 0; row < parts.q.size(); ++row) {
    const bool untried = parts.row_begin[row] == parts.row_begin[row + 1];
    const bool chosen = index_of(parts.policy[row / actions]) == row % actions;
    parts.forbidden.push_back(untried && !chosen ? 1 : 0);
    parts.collisions.push_back(untried ? 0 : 1);
  }
  auto chain = Chain::make(std::move(parts));
  COPPICE_CHECK(chain.has_value());
  return std::move(*chain);
}

void check_ticks_alike(const Tree& tree, const Tree& other) {
  static const std::vector<std::vector<std::uint8_t>> observations = [] {
    Xoshiro256 random(1);
    std::vector<std::vector<std::uint8_t>> result(64);
    for (std::vector<std::uint8_t>& observation : result) {
      for (const Feature& feature : words().features) {
        observation.push_back(feature.values[random.below(feature.values.size())]);
      }
    }
    return result;
  }();
  for (const std::vector<std::uint8_t>& observation : observations) {
    COPPICE_CHECK(tick(tree, observation) == tick(other, observation));
  }
}

}  // namespace coppice::fuzz
