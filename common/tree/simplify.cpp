#include "common/tree/simplify.hpp"

#include <fmt/format.h>
#include <optional>

#include "common/check.hpp"
#include "common/tree/flow.hpp"
#include "common/tree/text.hpp"

namespace coppice {
namespace {

enum class Fate : std::uint8_t { stays, goes, dissolves };  // dissolves: its children take its place

struct Plan {
  std::vector<Fate> fates;  // [nodes]
  std::vector<Removal> removals;
};

// One pass over a tree. A pass looks at the tree as it is and plans removals that are sound together; the next pass
// looks again.
class Pass {
 public:
  Pass(const Tree& tree, const Vocabulary& vocabulary)
      : tree_(tree), vocabulary_(vocabulary), plan_{std::vector<Fate>(tree.size(), Fate::stays), {}} {}

  Plan take() { return std::move(plan_); }

  // Composites with one child, and composites inside a composite of their kind.
  void dissolve(std::size_t i, std::optional<NodeKind> parent) {
    const Node& node = tree_[i];
    if (node.is_leaf()) {
      return;
    }
    if (child_count(tree_.subtree(i)) == 1) {
      plan(i, Fate::dissolves, fmt::format("a {} with one child", name_of(i)));
    } else if (parent == node.kind) {
      plan(i, Fate::dissolves, fmt::format("a {} inside a {}", name_of(i), name_of(i)));
    } else {
      parent = node.kind;
    }
    for (std::size_t child = i + 1; child < i + node.extent; child += tree_[child].extent) {
      dissolve(child, parent);
    }
  }

  // Nodes that are never reached; nodes whose status is decided and that write nothing that lasts. Each is
  // replaced by what it amounts to, so all of them can go at once: no status changes, and the last write of a tick is
  // never one of those that go.
  void drop_decided() {
    flow_ = flow_of(tree_, vocabulary_, Facts::used);
    drop(0, [this](std::size_t parent, std::size_t i) {
      return !flow_[i].reached || (is_skip(parent, i) && !flow_[i].lasts) ? decided_reason(parent, i) : std::string();
    });
  }

  // Nodes that write only what is on the blackboard already. Not in one pass with drop_decided(): of two equal
  // writes the first does not last and the second is redundant, and one of them must stay.
  void drop_redundant() {
    flow_ = flow_of(tree_, vocabulary_, Facts::used);
    drop(0, [this](std::size_t parent, std::size_t i) {
      return flow_[i].reached && is_skip(parent, i) && flow_[i].redundant
                 ? std::string("what it writes is on the blackboard already")
                 : std::string();
    });
  }

  // Nodes after which the tick ends with the same action whatever status they return. Their removal takes away what
  // later conditions are decided by, so no such fact may be used in the same pass.
  void drop_indifferent() {
    flow_ = flow_of(tree_, vocabulary_, Facts::ignored);
    drop(0, [this](std::size_t parent, std::size_t i) {
      const NodeFlow& flow = flow_[i];
      // The way on without the node must be one that exists with it: what counts as redundant there was found so.
      const bool goes_on = tree_[parent].kind == NodeKind::sequence ? flow.can_succeed : flow.can_fail;
      if (!(goes_on || flow.is_final) || flow.on_success != flow.on_failure) {
        return std::string();
      }
      if (flow.on_success.kind == Outcome::Kind::action) {
        return fmt::format("changes nothing: the tree ends with '{}' after it whether it succeeds or fails",
                           vocabulary_.actions[index_of(flow.on_success.action)]);
      }
      return flow.on_success.kind == Outcome::Kind::nothing && flow.redundant
                 ? std::string("changes nothing: no other action is written after it whether it succeeds or fails")
                 : std::string();
    });
  }

 private:
  std::string name_of(std::size_t i) const { return to_text(tree_[i], vocabulary_); }

  std::string text_of(std::size_t i) const {
    const std::span<const Node> subtree = tree_.subtree(i);
    const Result<Tree> tree = Tree::from_nodes({subtree.begin(), subtree.end()});
    COPPICE_CHECK(tree.has_value());
    return to_text(*tree, vocabulary_);
  }

  void plan(std::size_t i, Fate fate, std::string reason) {
    plan_.fates[i] = fate;
    plan_.removals.push_back({text_of(i), std::move(reason), fate == Fate::goes ? tree_[i].extent : std::size_t{1}});
  }

  // The parent goes on to its next child after i, always.
  bool is_skip(std::size_t parent, std::size_t i) const {
    return tree_[parent].kind == NodeKind::sequence ? !flow_[i].can_fail : !flow_[i].can_succeed;
  }

  // Plans the removal of the highest nodes that `reason_to_drop` gives a reason for. A composite keeps its smallest
  // child when all could go: its own status is wanted, or it is the whole tree.
  template <typename ReasonToDrop>
  void drop(std::size_t i, const ReasonToDrop& reason_to_drop) {
    if (tree_[i].is_leaf()) {
      return;
    }
    const std::size_t end = i + tree_[i].extent;
    std::size_t smallest = i + 1;
    bool all_go = true;
    std::vector<std::string> reasons;
    for (std::size_t child = i + 1; child < end; child += tree_[child].extent) {
      reasons.push_back(reason_to_drop(i, child));
      all_go = all_go && !reasons.back().empty();
      if (flow_[child].reached && tree_[child].extent < tree_[smallest].extent) {
        smallest = child;
      }
    }
    auto reason = reasons.begin();
    for (std::size_t child = i + 1; child < end; child += tree_[child].extent, ++reason) {
      if (reason->empty()) {
        drop(child, reason_to_drop);
      } else if (!all_go || child != smallest) {
        plan(child, Fate::goes, std::move(*reason));
      }
    }
  }

  std::string decided_reason(std::size_t parent, std::size_t i) const {
    const NodeFlow& flow = flow_[i];
    if (!flow.reached) {
      return unreached_reason(parent, i);
    }
    if (tree_[i].kind == NodeKind::condition) {
      return fmt::format("always {} here: decided by what is tested before it", flow.can_succeed ? "true" : "false");
    }
    if (tree_[i].kind == NodeKind::action) {
      return overwritten_in_sequence(parent, i)
                 ? "overwritten by an action later in the same sequence, with nothing between that can fail"
                 : "overwritten: another action is written later, whatever is observed";
    }
    return fmt::format("always {} here and writes nothing that lasts", flow.can_succeed ? "succeeds" : "fails");
  }

  std::string unreached_reason(std::size_t parent, std::size_t i) const {
    std::size_t last_reached = parent + 1;
    for (std::size_t child = parent + 1; child < i && flow_[child].reached; child += tree_[child].extent) {
      last_reached = child;
    }
    if (tree_[last_reached].kind == NodeKind::action) {
      return "never reached: it follows an action in a selector";
    }
    return fmt::format("never reached: it follows {}, which always {} here, in a {}", text_of(last_reached),
                       flow_[last_reached].can_succeed ? "succeeds" : "fails", name_of(parent));
  }

  bool overwritten_in_sequence(std::size_t parent, std::size_t i) const {
    if (tree_[parent].kind != NodeKind::sequence) {
      return false;
    }
    for (std::size_t next = i + 1; next < parent + tree_[parent].extent; next += tree_[next].extent) {
      if (tree_[next].kind == NodeKind::action) {
        return true;
      }
      if (flow_[next].can_fail) {
        return false;
      }
    }
    return false;
  }

  const Tree& tree_;
  const Vocabulary& vocabulary_;
  std::vector<NodeFlow> flow_;
  Plan plan_;
};

void copy_what_stays(const Tree& tree, const std::vector<Fate>& fates, std::size_t i, std::vector<Node>& out) {
  if (fates[i] == Fate::goes) {
    return;
  }
  const std::size_t root = out.size();
  if (fates[i] == Fate::stays) {
    out.push_back(tree[i]);
  }
  if (tree[i].is_composite()) {
    for (std::size_t child = i + 1; child < i + tree[i].extent; child += tree[child].extent) {
      copy_what_stays(tree, fates, child, out);
    }
  }
  if (fates[i] == Fate::stays) {
    out[root].extent = static_cast<std::uint16_t>(out.size() - root);
  }
}

Tree carried_out(const Tree& tree, const Plan& plan) {
  std::vector<Node> nodes;
  copy_what_stays(tree, plan.fates, 0, nodes);
  Result<Tree> result = Tree::from_nodes(std::move(nodes));
  COPPICE_CHECK(result.has_value());
  return *std::move(result);
}

// The first pass, in this order, that finds something to do.
Plan next_plan(const Tree& tree, const Vocabulary& vocabulary) {
  Pass structure(tree, vocabulary);
  structure.dissolve(0, std::nullopt);
  if (Plan plan = structure.take(); !plan.removals.empty()) {
    return plan;
  }
  for (const auto drop : {&Pass::drop_decided, &Pass::drop_redundant, &Pass::drop_indifferent}) {
    Pass pass(tree, vocabulary);
    (pass.*drop)();
    if (Plan plan = pass.take(); !plan.removals.empty()) {
      return plan;
    }
  }
  return {};
}

}  // namespace

Simplified simplify(const Tree& tree, const Vocabulary& vocabulary) {
  Simplified result{tree, {}};
  // Every plan that does anything leaves fewer nodes.
  for (std::size_t round = 0; round < kMaxTreeNodes; ++round) {
    Plan plan = next_plan(result.tree, vocabulary);
    if (plan.removals.empty()) {
      break;
    }
    result.tree = carried_out(result.tree, plan);
    std::move(plan.removals.begin(), plan.removals.end(), std::back_inserter(result.removals));
  }
  return result;
}

}  // namespace coppice
