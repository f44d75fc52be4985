// A chain of any size, drawn from a seed: for trying evaluation, transfer and memory at sizes that no example world
// reaches. It has the shape of a learned chain (local and far successors, uneven counts, a greedy policy), not its
// meaning.
#pragma once

#include <cstdint>

#include "common/chain/chain.hpp"
#include "common/error.hpp"

namespace coppice {

struct SyntheticShape {
  std::uint32_t states = 1'000'000;
  std::uint32_t actions = 3;
  std::uint32_t branching = 10;  // successors of each (state, action)
  std::uint32_t features = 12;
  std::uint64_t seed = 1;
};

// Features have the fewest values, 0 to v - 1, that tell all states apart, and admit both operators. The same shape
// gives the same chain, bit for bit. Errors name the flag: a number out of range, features that cannot tell so many
// states apart.
Result<Chain> synthetic_chain(const SyntheticShape& shape);

}  // namespace coppice
