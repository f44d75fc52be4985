#include "coordinator/studio/tree_view.hpp"

#include "common/chain/exact.hpp"
#include "coordinator/studio/page_numbers.hpp"
#include "coordinator/trust/jumps.hpp"

namespace coppice {

std::vector<double> expected_visits(const Chain& chain, const ChainActions& actions, std::uint32_t steps) {
  std::vector<double> visits(chain.states(), 0.0);
  ExactOccupancy exact(chain);
  const Occupancy& occupancy = exact.over_steps({.actions = actions, .others = {}, .others_share = 0.0}, steps);
  for (std::size_t i = 0; i < occupancy.states.size(); ++i) {
    visits[occupancy.states[i]] = occupancy.visits[i];
  }
  return visits;
}

TreeView view_of(const Chain& chain, const Tree& tree, const std::vector<double>& visits) {
  const std::vector<Jump> jumps = jumps_of(tree);
  const auto& q = chain.parts().q;
  TreeView view;
  view.nodes.resize(tree.size());
  for (std::size_t state = 0; state < chain.states(); ++state) {
    const auto features = chain.features_of(state);
    const double weight = visits[state];
    view.steps += weight;
    std::size_t writer = kTickEnds;
    for (std::size_t leaf = first_leaf(tree, 0); leaf != kTickEnds;) {
      const Node& node = tree[leaf];
      const bool succeeded = node.kind == NodeKind::action || holds(node, features[node.index]);
      view.nodes[leaf].ticked += weight;
      view.nodes[leaf].succeeded += succeeded ? weight : 0.0;
      writer = node.kind == NodeKind::action ? leaf : writer;
      leaf = succeeded ? jumps[leaf].on_success : jumps[leaf].on_failure;
    }
    if (writer == kTickEnds) {
      view.undecided += weight;
      continue;
    }
    NodeView& decider = view.nodes[writer];
    decider.decides += weight;
    ++decider.states;
    const ActionId policy = chain.policy(state);
    if (tree[writer].action() != policy && !chain.is_terminal(state)) {
      decider.differs += weight;
      ++decider.differing_states;
      const std::size_t taken = chain.taken(state, index_of(tree[writer].action()));
      const double value = taken < chain.actions() ? q[state * chain.actions() + taken] : 0.0;
      decider.cost += weight * (q[chain.row(state, policy)] - value);
    }
  }
  // A composite is ticked exactly when the leaf is to which a tick of it comes first.
  for (std::size_t node = 0; node < tree.size(); ++node) {
    if (tree[node].is_composite()) {
      view.nodes[node].ticked = view.nodes[first_leaf(tree, node)].ticked;
    }
  }
  return view;
}

nlohmann::ordered_json to_json(const TreeView& view) {
  const auto list = [&](auto member) {
    nlohmann::ordered_json values = nlohmann::ordered_json::array();
    for (const NodeView& node : view.nodes) {
      values.push_back(page_number(node.*member));
    }
    return values;
  };
  return {{"steps", page_number(view.steps)},
          {"undecided", page_number(view.undecided)},
          {"ticked", list(&NodeView::ticked)},
          {"succeeded", list(&NodeView::succeeded)},
          {"decides", list(&NodeView::decides)},
          {"differs", list(&NodeView::differs)},
          {"cost", list(&NodeView::cost)},
          {"states", list(&NodeView::states)},
          {"differing_states", list(&NodeView::differing_states)}};
}

}  // namespace coppice
