// What is earned at most: an upper bound for every tree of any size, and what a given choice of actions earns, on the
// same chain by the same rules (Chain::taken(); a pair that was never tried leads to every state alike, and earns
// nothing). By backward induction over the steps that are left (Bellman, Dynamic Programming, 1957),
//
//   V_k(s) = max over a of r(s, a) + sum over s' of P(s' | s, a) V_{k-1}(s'),   V_0 = 0
//
// so the best may choose by the step as well, which no tree can: that the bound is reached is not promised. Pure
// functions.
#pragma once

#include <cstdint>
#include <span>

#include "common/chain/chain.hpp"

namespace coppice {

// The expected reward of so many steps from where episodes start, whoever chooses. [reward]
double best_return(const Chain& chain, std::uint32_t steps);
// The same of these actions; the number of actions stands for none. [states] REQUIRES: actions.size() == states().
double return_of(const Chain& chain, std::span<const std::uint8_t> actions, std::uint32_t steps);

}  // namespace coppice
