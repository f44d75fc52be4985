#include "common/tree/guard.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <optional>
#include <unordered_map>
#include <vector>

#include "common/check.hpp"
#include "common/tree/decision_graph.hpp"
#include "common/tree/negation.hpp"
#include "common/tree/simplify.hpp"

namespace coppice {
namespace {

using Id = DecisionGraph::Id;

enum class Negations { none, where_they_can_be_written };

// Writes a decision graph as a guarded tree, choosing for each part the way that takes the fewest nodes.
//
// part(n, f) is a guarded tree for the decisions below n that FAILS, without having acted, exactly where they lead to
// f: its parent goes on with f. So f is written once, however often it is met. Where they lead to no action it
// succeeds without acting (or fails, if f is the end without an action). part(n, f) is nothing at all where n is f.
// A decision (e ? y : n) is then one of
//   (selector (sequence e part(y, n)) part(n, f))       (selector (sequence not-e part(n, y)) part(y, f))
//   (sequence e part(y, f))  where n is f               (sequence not-e part(n, f))  where y is f
//   (selector e part(n, f))  where y is no action       (selector not-e part(y, f))  where n is no action
//   (selector (sequence e part(y, f)) (sequence not-e part(n, f)))
//   (selector part(here, j) part(j, f))  for any j below that several ways lead to
class GuardedWriter {
 public:
  GuardedWriter(const DecisionGraph& graph, const Vocabulary& vocabulary, Negations negations)
      : graph_(graph),
        always_(always_true(vocabulary)),
        negation_of_(graph.size()),
        below_(graph.size(), std::vector<bool>(graph.size(), false)) {
    const std::vector<std::uint32_t> ways = graph.ways_in();
    for (std::size_t i = 0; i < graph.size(); ++i) {
      const Id id = static_cast<Id>(i);
      below_[i][i] = true;
      if (ways[i] > 1 && id != graph.none_end()) {
        joins_.push_back(id);
      }
      if (graph.is_end(id)) {
        continue;
      }
      const DecisionGraph::Decision& here = graph.decision(id);
      for (std::size_t j = 0; j < i; ++j) {
        below_[i][j] = below_[here.yes][j] || below_[here.no][j];
      }
      if (negations == Negations::where_they_can_be_written) {
        negation_of_[i] = negation(here.test, vocabulary);
      }
    }
    if (joins_.size() > kMaxJoins) {
      joins_.clear();
    }
  }

  // Nothing where the tree would exceed kMaxTreeNodes.
  std::optional<std::vector<Node>> write() {
    const Id root = graph_.root();
    const Plan plan = plan_of(root, graph_.none_end());
    if (plan.nodes > kMaxTreeNodes) {
      return std::nullopt;
    }
    if (plan.way == Way::nothing) {  // the tree never acts: any test will do
      return always_;
    }
    std::vector<Node> nodes = written(root, graph_.none_end());
    COPPICE_CHECK(nodes.size() == plan.nodes);
    return nodes;
  }

 private:
  static constexpr Id kNowhere = UINT32_MAX;          // as f: nothing leads there
  static constexpr std::size_t kMaxJoins = 64;        // more are not tried: the work grows with their square
  static constexpr std::size_t kTooMany = 1U << 20U;  // nodes; sums of a few such stay exact

  enum class Way : std::uint8_t {
    nothing,
    action,
    always,
    test,
    not_test,
    test_or_rest,
    not_test_or_rest,
    test_then_yes,
    not_test_then_no,
    yes_else_no,
    no_else_yes,
    both,
    join
  };

  struct Plan {
    std::size_t nodes = kTooMany;
    NodeKind kind = NodeKind::action;  // of its root: one of the kind around it gives up its own root
    Way way = Way::nothing;
    Id join = 0;
  };

  static std::size_t nodes_inside(NodeKind around, const Plan& plan) {
    return plan.nodes - (plan.nodes > 0 && plan.kind == around ? 1 : 0);
  }
  static std::size_t nodes_inside(NodeKind around, const std::vector<Node>& test) {
    return test.size() - (test.front().kind == around ? 1 : 0);
  }

  Plan plan_of(Id n, Id f) {
    if (n == f) {
      return {.nodes = 0, .way = Way::nothing};
    }
    if (n == graph_.none_end()) {
      return {.nodes = always_.size(), .kind = always_.front().kind, .way = Way::always};
    }
    if (graph_.is_end(n)) {
      return {.nodes = 1, .way = Way::action};
    }
    if (f != kNowhere && !below_[n][f]) {
      f = kNowhere;
    }
    const std::uint64_t key = (std::uint64_t{n} << 32U) | f;
    if (const auto known = plans_.find(key); known != plans_.end()) {
      return known->second;
    }
    const Plan plan = best_plan(n, f);
    plans_.emplace(key, plan);
    return plan;
  }

  Plan best_plan(Id n, Id f) {
    const DecisionGraph::Decision& here = graph_.decision(n);
    const std::optional<std::vector<Node>>& negated = negation_of_[n];
    Plan best;
    const auto offer = [&](std::size_t nodes, NodeKind kind, Way way, Id join = 0) {
      if (nodes < best.nodes) {
        best = {nodes, kind, way, join};
      }
    };
    // One test, as the yes-side if `test` is the test itself, as the no-side if it is its negation.
    const auto offer_side = [&](const std::vector<Node>& test, Id taken, Id other, const std::array<Way, 4>& ways) {
      const std::size_t in_selector = nodes_inside(NodeKind::selector, test);
      const std::size_t in_sequence = nodes_inside(NodeKind::sequence, test);
      if (taken == graph_.none_end()) {
        if (other == f) {
          offer(test.size(), test.front().kind, ways[0]);
        } else {
          offer(1 + in_selector + nodes_inside(NodeKind::selector, plan_of(other, f)), NodeKind::selector, ways[1]);
        }
      }
      if (other == f) {
        if (taken != f) {
          offer(1 + in_sequence + nodes_inside(NodeKind::sequence, plan_of(taken, f)), NodeKind::sequence, ways[2]);
        }
      } else {
        const std::size_t guarded = 1 + in_sequence + nodes_inside(NodeKind::sequence, plan_of(taken, other));
        offer(1 + guarded + nodes_inside(NodeKind::selector, plan_of(other, f)), NodeKind::selector, ways[3]);
      }
    };
    offer_side(here.test, here.yes, here.no, {Way::test, Way::test_or_rest, Way::test_then_yes, Way::yes_else_no});
    if (negated) {
      offer_side(*negated, here.no, here.yes,
                 {Way::not_test, Way::not_test_or_rest, Way::not_test_then_no, Way::no_else_yes});
      if (here.yes != f && here.no != f && f != kNowhere) {
        const std::size_t yes =
            1 + nodes_inside(NodeKind::sequence, here.test) + nodes_inside(NodeKind::sequence, plan_of(here.yes, f));
        const std::size_t no =
            1 + nodes_inside(NodeKind::sequence, *negated) + nodes_inside(NodeKind::sequence, plan_of(here.no, f));
        offer(1 + yes + no, NodeKind::selector, Way::both);
      }
    }
    // Joins above f only, so that this ends: f rises with every one.
    for (const Id join : joins_) {
      if (join < n && below_[n][join] && (f == kNowhere || join > f)) {
        offer(
            1 + nodes_inside(NodeKind::selector, plan_of(n, join)) + nodes_inside(NodeKind::selector, plan_of(join, f)),
            NodeKind::selector, Way::join, join);
      }
    }
    best.nodes = std::min(best.nodes, kTooMany);
    return best;
  }

  static std::vector<Node> sequence(const std::vector<Node>& a, const std::vector<Node>& b) {
    return joined(NodeKind::sequence, a, b);
  }
  static std::vector<Node> selector(const std::vector<Node>& a, const std::vector<Node>& b) {
    return joined(NodeKind::selector, a, b);
  }

  // REQUIRES: plan_of(n, f) is something, of at most kMaxTreeNodes nodes.
  std::vector<Node> written(Id n, Id f) {
    const Plan plan = plan_of(n, f);
    if (plan.way == Way::action) {
      return {Node::action(graph_.action_of(n))};
    }
    if (plan.way == Way::always) {
      return always_;
    }
    const auto& [test, yes, no] = graph_.decision(n);
    const std::optional<std::vector<Node>>& negated = negation_of_[n];
    switch (plan.way) {
      case Way::test:
        return test;
      case Way::not_test:
        return *negated;
      case Way::test_or_rest:
        return selector(test, written(no, f));
      case Way::not_test_or_rest:
        return selector(*negated, written(yes, f));
      case Way::test_then_yes:
        return sequence(test, written(yes, f));
      case Way::not_test_then_no:
        return sequence(*negated, written(no, f));
      case Way::yes_else_no:
        return selector(sequence(test, written(yes, no)), written(no, f));
      case Way::no_else_yes:
        return selector(sequence(*negated, written(no, yes)), written(yes, f));
      case Way::both:
        return selector(sequence(test, written(yes, f)), sequence(*negated, written(no, f)));
      case Way::join:
        return selector(written(n, plan.join), written(plan.join, f));
      case Way::nothing:
      case Way::action:
      case Way::always:
        break;
    }
    COPPICE_CHECK(false);
    return {};
  }

  const DecisionGraph& graph_;
  std::vector<Node> always_;
  std::vector<std::optional<std::vector<Node>>> negation_of_;  // [graph nodes]
  std::vector<std::vector<bool>> below_;                       // [from][to], itself included
  std::vector<Id> joins_;
  std::unordered_map<std::uint64_t, Plan> plans_;
};

}  // namespace

bool is_guarded(const Tree& tree) {
  const std::span<const Node> nodes = tree.nodes();
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (nodes[i].kind != NodeKind::sequence) {
      continue;
    }
    const std::size_t end = i + nodes[i].extent;
    for (std::size_t child = i + 1; child + nodes[child].extent < end; child += nodes[child].extent) {
      const auto subtree = tree.subtree(child);
      if (std::any_of(subtree.begin(), subtree.end(), [](const Node& n) { return n.kind == NodeKind::action; })) {
        return false;
      }
    }
  }
  return true;
}

Result<Tree> guard(const Tree& tree, const Vocabulary& vocabulary) {
  std::optional<Tree> best;
  const auto offer = [&](Tree candidate) {
    COPPICE_CHECK(is_guarded(candidate));
    if (!best || candidate.size() < best->size()) {
      best = std::move(candidate);
    }
  };
  const Tree simplified = simplify(tree, vocabulary).tree;
  if (is_guarded(simplified)) {
    offer(simplified);
  }
  const DecisionGraph as_written(simplified, vocabulary);
  DecisionGraph shared_first = as_written;
  shared_first.ask_shared_tests_first();
  std::string obstacle =
      fmt::format("the guarded form is too large: expected at most {} nodes and {} edges from the root", kMaxTreeNodes,
                  kMaxTreeDepth);
  for (DecisionGraph graph : {as_written, std::move(shared_first)}) {
    if (const std::size_t tests = graph.size() - graph.ends(); tests > kMaxGuardTests) {
      obstacle = fmt::format(
          "{} tests, each counted once for every action that it is met with: expected at most {} for the guarded form",
          tests, kMaxGuardTests);
      continue;
    }
    graph.join_tests();
    for (const Negations negations : {Negations::none, Negations::where_they_can_be_written}) {
      if (std::optional<std::vector<Node>> nodes = GuardedWriter(graph, vocabulary, negations).write()) {
        if (const Result<Tree> written = Tree::from_nodes(*std::move(nodes))) {
          offer(simplify(*written, vocabulary).tree);
        }
      }
    }
  }
  if (!best) {
    return bad_input(obstacle);
  }
  return *std::move(best);
}

}  // namespace coppice
