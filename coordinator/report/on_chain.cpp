#include "coordinator/report/on_chain.hpp"

#include "common/chain/exact.hpp"
#include "common/tree/action_table.hpp"
#include "common/tree/state_columns.hpp"

namespace coppice {

ChainActions actions_of(const Chain& chain, const Tree& tree) {
  ChainActions actions(chain.states());
  fill_action_table(tree, StateColumns(chain.vocabulary(), chain.parts().features),
                    static_cast<std::uint8_t>(chain.actions()), actions);
  return actions;
}

ChainActions actions_of_policy(const Chain& chain) {
  ChainActions actions;
  actions.reserve(chain.states());
  for (const ActionId action : chain.parts().policy) {
    actions.push_back(static_cast<std::uint8_t>(action));
  }
  return actions;
}

std::size_t matching_states(const Chain& chain, const ChainActions& actions, std::uint64_t fewest_visits) {
  std::size_t matches = 0;
  for (std::size_t state = 0; state < actions.size(); ++state) {
    const bool agrees = actions[state] == index_of(chain.policy(state)) || chain.is_terminal(state);
    if (agrees && chain.parts().visits[state] >= fewest_visits) {
      ++matches;
    }
  }
  return matches;
}

ExpectedScore expected_score(const Chain& chain, const ChainActions& actions, std::uint32_t steps) {
  ExactOccupancy exact(chain);
  const Occupancy& occupancy = exact.over_steps({.actions = actions, .others = {}, .others_share = 0.0}, steps);
  ExpectedScore score;
  for (std::size_t i = 0; i < occupancy.states.size(); ++i) {
    const std::size_t state = occupancy.states[i];
    if (actions[state] == index_of(chain.policy(state)) || chain.is_terminal(state)) {
      score.agreement += occupancy.visits[i];
    }
    if (const std::size_t taken = chain.taken(state, actions[state]); taken < chain.actions()) {
      score.reward += occupancy.visits[i] * chain.mean_reward(state * chain.actions() + taken);
    }
  }
  score.agreement /= static_cast<double>(steps);
  return score;
}

}  // namespace coppice
