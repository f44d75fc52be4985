// Chains whose answers are known, and random ones. The vocabulary of all has one feature a bit of the state's number
// ("b0", "b1", ...; values 0 and 1) unless said otherwise.
#pragma once

#include <cstdint>
#include <memory>

#include "common/chain/chain.hpp"

namespace coppice::oracles {

// Knuth and Yao's die from a fair coin (1976): states 0..6 are coin flips, 7..12 the faces 1..6, which stay. One
// action, "flip". Every face has probability 1/6; the expected number of flips is 11/3. Reward 1 a flip, 0 in a face.
Chain knuth_die();

// The gambler's ruin with fortune 0..goal, start at `fortune`, winning with probability wins / (wins + losses) a
// round. One action, "bet"; reward 1 on reaching the goal. P(goal) = (1 - r^fortune) / (1 - r^goal), r = losses / wins.
struct Gambler {
  std::uint32_t fortune = 3;
  std::uint32_t goal = 10;
  std::uint32_t wins = 9;
  std::uint32_t losses = 10;
};
Chain gamblers_ruin(const Gambler& gambler);

// A chain drawn from a seed: rows of 1 to 12 successors, about one pair in ten never tried, rewards and Q-values
// within +-20. Features f0..f5 with values {0, 1, 3}; f5 admits <= too. REQUIRES: states <= 3^6, actions <= 8.
struct RandomChain {
  std::uint32_t states = 200;
  std::uint32_t actions = 3;
  std::uint64_t seed = 1;
};
Chain random_chain(const RandomChain& shape);
std::shared_ptr<const Chain> shared_random_chain(const RandomChain& shape);

}  // namespace coppice::oracles
