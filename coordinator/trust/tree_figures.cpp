#include "coordinator/trust/tree_figures.hpp"

#include <fmt/format.h>

namespace coppice {
namespace {

constexpr std::size_t kName = 28;
constexpr std::size_t kCell = 20;

}  // namespace

TreeFigures figures_of(const Chain& chain, const ChainActions& actions, std::uint32_t steps) {
  return {.states = chain.states(),
          .matching_states = matching_states(chain, actions),
          .along_chain = expected_score(chain, actions, steps)};
}

TreeFigures figures_of(const Chain& chain, const Tree& tree, std::uint32_t steps) {
  TreeFigures figures = figures_of(chain, actions_of(chain, tree), steps);
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
       [&](std::size_t i) { return fmt::format("{:.1f} % exactly", 100.0 * figures[i].along_chain.agreement); });
  line("reward along the chain",
       [&](std::size_t i) { return fmt::format("{:.1f} exactly", figures[i].along_chain.reward); });
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
