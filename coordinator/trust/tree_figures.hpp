// How good a tree is, in the few figures that a designer compares before and after a change: exact ones on the chain,
// and those of the simulator where there is one.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/tree/tree.hpp"
#include "coordinator/report/score.hpp"

namespace coppice {

struct TreeFigures {
  std::size_t nodes = 0;
  std::size_t states = 0;           // of the chain
  std::size_t matching_states = 0;  // where the tree does what the policy does
  ExpectedScore along_chain;
  std::optional<ControllerScore> simulated = {};

  double coverage() const { return static_cast<double>(matching_states) / static_cast<double>(states); }
};

// Along the chain over `steps` steps (common/chain/exact.hpp). REQUIRES: check_tree() for the chain's vocabulary.
TreeFigures figures_of(const Chain& chain, const Tree& tree, std::uint32_t steps);
// The same for whatever takes these actions.
TreeFigures figures_of(const Chain& chain, const ChainActions& actions, std::uint32_t steps);

// A line for each figure, a column for each tree. REQUIRES: as many titles as figures.
std::string side_by_side(const std::vector<std::string>& titles, const std::vector<TreeFigures>& figures);

}  // namespace coppice
