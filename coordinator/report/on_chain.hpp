// A controller on the chain, without chance: in how many states it acts as the policy does, and what its walks are
// expected to give.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/tree/tree.hpp"

namespace coppice {

// [states], the index of the action; Chain::actions() where there is none.
using ChainActions = std::vector<std::uint8_t>;

// REQUIRES: check_tree() for the chain's vocabulary.
ChainActions actions_of(const Chain& chain, const Tree& tree);
ChainActions actions_of_policy(const Chain& chain);

// Of the states that were visited so often or more in learning. Where an episode ends whatever is chosen matches.
std::size_t matching_states(const Chain& chain, const ChainActions& actions, std::uint64_t fewest_visits = 0);

struct ExpectedScore {
  double agreement = 0.0;  // share of the steps, in [0, 1]
  double reward = 0.0;     // per episode: the sum of the mean rewards recorded for each (state, action)
};

// Over `steps` steps from the initial state, computed (common/chain/exact.hpp). Without an action the
// chain says what takes place (Chain::taken).
ExpectedScore expected_score(const Chain& chain, const ChainActions& actions, std::uint32_t steps);

}  // namespace coppice
