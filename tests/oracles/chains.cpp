#include "tests/oracles/chains.hpp"

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "common/chain/random.hpp"
#include "common/check.hpp"

namespace coppice::oracles {
namespace {

// Rows are appended in state-major order.
class Rows {
 public:
  explicit Rows(ChainParts& parts) : parts_(parts) { parts_.row_begin = {0}; }
  void add(const std::vector<std::pair<std::uint32_t, std::uint32_t>>& successors, double reward_sum, double q = 0.0) {
    for (const auto& [state, count] : successors) {
      parts_.successor.push_back(state);
      parts_.count.push_back(count);
    }
    parts_.row_begin.push_back(parts_.successor.size());
    parts_.reward_sum.push_back(reward_sum);
    parts_.q.push_back(q);
  }

 private:
  ChainParts& parts_;
};

void number_states(std::uint32_t states, std::uint32_t bits, ChainParts& parts) {
  for (std::uint32_t bit = 0; bit < bits; ++bit) {
    parts.vocabulary.features.push_back({"b" + std::to_string(bit), {0, 1}, true, false});
  }
  for (std::uint32_t state = 0; state < states; ++state) {
    for (std::uint32_t bit = 0; bit < bits; ++bit) {
      parts.features.push_back(static_cast<std::uint8_t>(state >> bit & 1U));
    }
  }
  parts.policy.assign(states, ActionId{0});
  parts.visits.assign(states, 1);
}

Chain checked(ChainParts parts) {
  auto chain = Chain::make(std::move(parts));
  COPPICE_CHECK(chain.has_value());
  return std::move(*chain);
}

}  // namespace

Chain knuth_die() {
  ChainParts parts;
  parts.vocabulary.actions = {"flip"};
  number_states(13, 4, parts);
  Rows rows(parts);
  // s0 -> s1 | s2; s1 -> s3 | s4; s2 -> s5 | s6; s3 -> s1 | 1; s4 -> 2 | 3; s5 -> 4 | 5; s6 -> 6 | s2.
  constexpr std::array<std::array<std::uint32_t, 2>, 7> kFlips = {
      {{1, 2}, {3, 4}, {5, 6}, {1, 7}, {8, 9}, {10, 11}, {2, 12}}};
  for (const auto& flip : kFlips) {
    rows.add({{flip[0], 1}, {flip[1], 1}}, 2.0);
  }
  for (std::uint32_t face = 7; face < 13; ++face) {
    rows.add({{face, 1}}, 0.0);
  }
  return checked(std::move(parts));
}

Chain gamblers_ruin(const Gambler& gambler) {
  ChainParts parts;
  parts.vocabulary.actions = {"bet"};
  number_states(gambler.goal + 1, 6, parts);
  parts.initial_state = gambler.fortune;
  Rows rows(parts);
  rows.add({{0, 1}}, 0.0);
  for (std::uint32_t fortune = 1; fortune < gambler.goal; ++fortune) {
    const double reward = fortune + 1 == gambler.goal ? gambler.wins : 0.0;
    rows.add({{fortune - 1, gambler.losses}, {fortune + 1, gambler.wins}}, reward);
  }
  rows.add({{gambler.goal, 1}}, 0.0);
  return checked(std::move(parts));
}

Chain random_chain(const RandomChain& shape) {
  constexpr std::uint32_t kFeatures = 6;
  constexpr std::array<std::uint8_t, 3> kValues = {0, 1, 3};
  COPPICE_CHECK(shape.states <= 729 && shape.actions <= 8);
  Xoshiro256 random(shape.seed);
  ChainParts parts;
  for (std::uint32_t f = 0; f < kFeatures; ++f) {
    parts.vocabulary.features.push_back({"f" + std::to_string(f), {0, 1, 3}, true, f == 5});
  }
  for (std::uint32_t a = 0; a < shape.actions; ++a) {
    parts.vocabulary.actions.push_back("a" + std::to_string(a));
  }
  for (std::uint32_t state = 0; state < shape.states; ++state) {
    for (std::uint32_t f = 0, rest = state; f < kFeatures; ++f, rest /= 3) {
      parts.features.push_back(kValues[rest % 3]);
    }
    parts.visits.push_back(random.below(1000));
  }
  Rows rows(parts);
  for (std::uint32_t row = 0; row < shape.states * shape.actions; ++row) {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> successors;
    const auto wanted = static_cast<std::uint32_t>(random.below(10) == 0 ? 0 : 1 + random.below(12));
    std::uint32_t next = static_cast<std::uint32_t>(random.below(shape.states / 12 + 1));
    for (std::uint32_t i = 0; i < wanted && next < shape.states; ++i) {
      successors.emplace_back(next, static_cast<std::uint32_t>(1 + random.below(1000)));
      next += static_cast<std::uint32_t>(1 + random.below(shape.states / 12 + 1));
    }
    const double reward = successors.empty() ? 0.0 : static_cast<double>(random.below(40001)) / 1000.0 - 20.0;
    rows.add(successors, reward, static_cast<double>(random.below(40001)) / 1000.0 - 20.0);
  }
  parts.policy = greedy_policy(parts.q, shape.actions);
  parts.initial_state = static_cast<std::uint32_t>(random.below(shape.states));
  return checked(std::move(parts));
}

std::shared_ptr<const Chain> shared_random_chain(const RandomChain& shape) {
  return std::make_shared<const Chain>(random_chain(shape));
}

}  // namespace coppice::oracles
