#include "coordinator/trust/tree_figures.hpp"

#include <fmt/format.h>

#include "common/chain/exact.hpp"
#include "common/tree/action_table.hpp"
#include "common/tree/state_columns.hpp"

namespace coppice {
namespace {

constexpr std::size_t kName = 28;
constexpr std::size_t kCell = 20;

}  // namespace

TreeFigures figures_of(const Chain& chain, const std::vector<std::uint8_t>& actions, std::uint32_t steps) {
  TreeFigures figures;
  figures.states = chain.states();
  for (std::size_t state = 0; state < chain.states(); ++state) {
    figures.matching_states += actions[state] == index_of(chain.policy(state)) ? 1U : 0U;
  }
  ExactOccupancy exact(chain);
  const Occupancy& occupancy = exact.over_steps({.actions = actions, .others = {}, .others_share = 0.0}, steps);
  for (std::size_t i = 0; i < occupancy.states.size(); ++i) {
    const std::size_t state = occupancy.states[i];
    figures.agreement += actions[state] == index_of(chain.policy(state)) ? occupancy.visits[i] : 0.0;
    if (actions[state] < chain.actions()) {
      figures.reward += occupancy.visits[i] * chain.mean_reward(chain.row(state, ActionId{actions[state]}));
    }
  }
  figures.agreement /= static_cast<double>(steps);
  return figures;
}

TreeFigures figures_of(const Chain& chain, const Tree& tree, std::uint32_t steps) {
  std::vector<std::uint8_t> actions(chain.states());
  fill_action_table(tree, StateColumns(chain.vocabulary(), chain.parts().features),
                    static_cast<std::uint8_t>(chain.actions()), actions);
  TreeFigures figures = figures_of(chain, actions, steps);
  figures.nodes = tree.size();
  return figures;
}

std::string side_by_side(const std::vector<std::string>& titles, const std::vector<TreeFigures>& figures) {
  std::string text;
  const auto line = [&](const std::string& name, const auto& cell) {
    std::string row = fmt::format("  {:<{}}", name, kName);
    for (std::size_t i = 0; i < figures.size(); ++i) {
      row += fmt::format("{:<{}}", cell(i), kCell);
    }
    row.erase(row.find_last_not_of(' ') + 1);
    text += row + '\n';
  };
  line("", [&](std::size_t i) { return titles[i]; });
  line("nodes", [&](std::size_t i) { return std::to_string(figures[i].nodes); });
  line("agreement over all states",
       [&](std::size_t i) { return fmt::format("{:.1f} %", 100.0 * figures[i].coverage()); });
  line("agreement along the chain",
       [&](std::size_t i) { return fmt::format("{:.1f} % exactly", 100.0 * figures[i].agreement); });
  line("reward along the chain", [&](std::size_t i) { return fmt::format("{:.1f} exactly", figures[i].reward); });
  if (!figures.front().simulated) {
    return text;
  }
  line("agreement in simulation", [&](std::size_t i) {
    const Estimate& agreement = figures[i].simulated->agreement;
    return fmt::format("{:.1f} % +- {:.1f}", 100.0 * agreement.mean, 100.0 * agreement.margin);
  });
  line("reward in simulation", [&](std::size_t i) {
    return fmt::format("{:.1f} +- {:.1f}", figures[i].simulated->reward.mean, figures[i].simulated->reward.margin);
  });
  line("collisions", [&](std::size_t i) { return std::to_string(figures[i].simulated->total_collisions); });
  return text;
}

}  // namespace coppice
