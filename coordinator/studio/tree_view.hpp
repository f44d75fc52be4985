// A tree on a chain, node by node: how often each is ticked, how often it has the last word, and what goes wrong then.
// Weighted with the expected visits of a walk through the chain, computed (common/chain/exact.hpp), not sampled. The
// page draws heat from it. Pure functions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/tree/tree.hpp"
#include "coordinator/report/on_chain.hpp"

namespace coppice {

// Expected visits of every state in a walk of `steps` steps from the initial state when these actions are taken.
// [states], sums to steps.
std::vector<double> expected_visits(const Chain& chain, const ChainActions& actions, std::uint32_t steps);

struct NodeView {
  double ticked = 0.0;     // steps of a walk in which a tick comes here
  double succeeded = 0.0;  // of these, leaves: the node succeeds; composites: 0, they say nothing that leaves do not
  double decides = 0.0;    // steps in which it has the last word: actions only
  double differs = 0.0;    // of these, the policy does something else
  double cost = 0.0;       // of differing: visits x (V - Q of what is done), as in coordinator/trust/disagreement.hpp
  std::size_t states = 0;  // of the chain in which it decides, visited or not
  std::size_t differing_states = 0;
};

struct TreeView {
  double steps = 0.0;           // of a walk: the sum of all visits
  double undecided = 0.0;       // steps in which no node decides: the tree has no action
  std::vector<NodeView> nodes;  // [nodes], in prefix order
};

// visits: [states], of whichever walk the view is weighted with. REQUIRES: check_tree(tree, chain.vocabulary()).
TreeView view_of(const Chain& chain, const Tree& tree, const std::vector<double>& visits);

// {"steps", "undecided", "ticked": [nodes], "succeeded": [...], ...}: a list a figure.
nlohmann::ordered_json to_json(const TreeView& view);

}  // namespace coppice
