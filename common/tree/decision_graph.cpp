#include "common/tree/decision_graph.hpp"

#include <utility>

#include "common/check.hpp"

namespace coppice {
namespace {

constexpr std::size_t kTickEnds = SIZE_MAX;

// Where a tick goes on after every leaf: another leaf, further on in the tree, or kTickEnds.
class Ways {
 public:
  explicit Ways(std::span<const Node> nodes) : nodes_(nodes), success_(nodes.size()), failure_(nodes.size()) {
    lead(0, kTickEnds, kTickEnds);
  }

  std::size_t on_success(std::size_t leaf) const { return success_[leaf]; }
  std::size_t on_failure(std::size_t leaf) const { return failure_[leaf]; }

  std::size_t first_leaf(std::size_t i) const {
    while (nodes_[i].is_composite()) {
      ++i;
    }
    return i;
  }

 private:
  // As deep as the tree: kMaxTreeDepth.
  void lead(std::size_t i, std::size_t success, std::size_t failure) {
    success_[i] = success;
    failure_[i] = failure;
    const bool is_sequence = nodes_[i].kind == NodeKind::sequence;
    const std::size_t end = i + nodes_[i].extent;
    for (std::size_t child = i + 1; child < end; child += nodes_[child].extent) {
      const std::size_t next = child + nodes_[child].extent;
      const std::size_t onward = next < end ? first_leaf(next) : (is_sequence ? success : failure);
      is_sequence ? lead(child, onward, failure) : lead(child, success, onward);
    }
  }

  std::span<const Node> nodes_;
  std::vector<std::size_t> success_;
  std::vector<std::size_t> failure_;
};

void append_part(NodeKind kind, const std::vector<Node>& part, std::vector<Node>& out) {
  out.insert(out.end(), part.begin() + (part.front().kind == kind ? 1 : 0), part.end());
}

}  // namespace

std::vector<Node> joined(NodeKind kind, const std::vector<Node>& a, const std::vector<Node>& b) {
  std::vector<Node> result = {Node::composite(kind, 0)};
  append_part(kind, a, result);
  append_part(kind, b, result);
  result.front().extent = static_cast<std::uint16_t>(result.size());
  return result;
}

DecisionGraph::DecisionGraph(const Tree& tree, const Vocabulary& vocabulary) : actions_(vocabulary.actions.size()) {
  const Ways ways(tree.nodes());
  const std::size_t boards = ends();  // what can be on the blackboard: the ids of the ends
  std::vector<bool> reached(tree.size() * boards, false);
  const auto reach = [&](std::size_t leaf, std::size_t board) {
    if (leaf != kTickEnds) {
      reached[leaf * boards + board] = true;
    }
  };
  // Every way leads further on, so one pass forwards finds all points and one pass backwards knows where they lead.
  const std::size_t first = ways.first_leaf(0);
  reach(first, none_end());
  for (std::size_t i = 0; i < tree.size(); ++i) {
    for (std::size_t board = 0; board < boards; ++board) {
      if (!reached[i * boards + board]) {
        continue;
      }
      const bool acts = tree[i].kind == NodeKind::action;
      reach(ways.on_success(i), acts ? tree[i].index : board);
      if (!acts) {
        reach(ways.on_failure(i), board);
      }
    }
  }
  std::vector<Id> id_of(tree.size() * boards, 0);
  const auto id_at = [&](std::size_t leaf, std::size_t board) {
    return leaf == kTickEnds ? static_cast<Id>(board) : id_of[leaf * boards + board];
  };
  for (std::size_t i = tree.size(); i-- > 0;) {
    const Node& leaf = tree[i];
    for (std::size_t board = 0; board < boards; ++board) {
      if (!reached[i * boards + board]) {
        continue;
      }
      Id& id = id_of[i * boards + board];
      if (leaf.kind == NodeKind::action) {
        id = id_at(ways.on_success(i), leaf.index);
        continue;
      }
      id = node_of(leaf, id_at(ways.on_success(i), board), id_at(ways.on_failure(i), board));
    }
  }
  root_ = id_at(first, none_end());
}

DecisionGraph::Id DecisionGraph::node_of(const Node& condition, Id yes, Id no) {
  if (yes == no) {
    return yes;
  }
  const Key key = {condition.index, condition.op, condition.value, yes, no};
  const auto [place, is_new] = known_.try_emplace(key, static_cast<Id>(size()));
  if (is_new) {
    decisions_.push_back({{condition}, yes, no});
  }
  return place->second;
}

DecisionGraph::Id DecisionGraph::asked_first(const Node& condition, Id yes, Id no) {
  if (!is_end(yes) && decision(yes).test.front() == condition) {
    yes = decision(yes).yes;
  }
  if (!is_end(no) && decision(no).test.front() == condition) {
    no = decision(no).no;
  }
  if (!is_end(yes) && !is_end(no) && yes != no) {
    const Decision of_yes = decision(yes);
    const Decision of_no = decision(no);
    if (of_yes.test == of_no.test) {
      if (of_yes.yes == of_no.yes) {
        return node_of(of_yes.test.front(), of_yes.yes, asked_first(condition, of_yes.no, of_no.no));
      }
      if (of_yes.no == of_no.no) {
        return node_of(of_yes.test.front(), asked_first(condition, of_yes.yes, of_no.yes), of_yes.no);
      }
    }
  }
  return node_of(condition, yes, no);
}

void DecisionGraph::ask_shared_tests_first() {
  const std::vector<std::uint32_t> count = ways_in();
  std::vector<Id> now(size());
  const std::size_t before = size();
  for (std::size_t id = 0; id < before; ++id) {
    now[id] = static_cast<Id>(id);
    if (id >= ends() && count[id] > 0) {
      const Decision here = decision(static_cast<Id>(id));
      now[id] = asked_first(here.test.front(), now[here.yes], now[here.no]);
    }
  }
  root_ = now[root_];
  drop_unreached();
}

void DecisionGraph::drop_unreached() {
  const std::vector<std::uint32_t> count = ways_in();
  std::vector<Id> now(size());
  std::vector<Decision> kept;
  for (std::size_t id = 0; id < size(); ++id) {
    now[id] = static_cast<Id>(id < ends() ? id : ends() + kept.size());
    if (id >= ends() && count[id] > 0) {
      Decision& here = decision(static_cast<Id>(id));
      kept.push_back({std::move(here.test), now[here.yes], now[here.no]});
    }
  }
  decisions_ = std::move(kept);
  root_ = now[root_];
  known_.clear();
}

std::vector<std::uint32_t> DecisionGraph::ways_in() const {
  std::vector<std::uint32_t> count(size(), 0);
  count[root_] = 1;
  for (std::size_t id = size(); id-- > ends();) {
    if (count[id] > 0) {
      ++count[decision(static_cast<Id>(id)).yes];
      ++count[decision(static_cast<Id>(id)).no];
    }
  }
  return count;
}

void DecisionGraph::join_tests() {
  std::vector<std::uint32_t> count = ways_in();
  // A round that joins anything leaves fewer decisions.
  bool changed = true;
  for (std::size_t round = 0; changed && round < kMaxTreeNodes; ++round) {
    changed = false;
    for (std::size_t i = ends(); i < size(); ++i) {
      const Id id = static_cast<Id>(i);
      Decision& here = decision(id);
      if (count[id] == 0) {
        continue;
      }
      const auto join = [&](NodeKind kind, Id next, Id shared, Id other) {
        here.test = joined(kind, here.test, decision(next).test);
        count[next] = 0;
        --count[shared];
        (kind == NodeKind::selector ? here.no : here.yes) = other;
        changed = true;
      };
      // Each turn joins one decision.
      while (true) {
        if (!is_end(here.no) && count[here.no] == 1 && decision(here.no).yes == here.yes) {
          join(NodeKind::selector, here.no, here.yes, decision(here.no).no);
        } else if (!is_end(here.yes) && count[here.yes] == 1 && decision(here.yes).no == here.no) {
          join(NodeKind::sequence, here.yes, here.no, decision(here.yes).yes);
        } else {
          break;
        }
      }
    }
  }
  drop_unreached();
}

}  // namespace coppice
