#include "common/tree/random_tree.hpp"

#include <algorithm>

#include "common/check.hpp"

namespace coppice {
namespace {

constexpr int kMutationDraws = 8;

Node action_at(std::size_t index) { return Node::action(ActionId{static_cast<std::uint8_t>(index)}); }

class Growth {
 public:
  Growth(const Vocabulary& vocabulary, const TreeShape& shape, const Below& below)
      : vocabulary_(vocabulary), shape_(shape), below_(below) {}

  void grow(std::size_t depth, bool composite_wanted) {
    const std::size_t free = shape_.max_nodes - promised_;
    if (depth == shape_.max_depth || free < kMinChildren || !(composite_wanted || below_(4) != 0)) {
      nodes_.push_back(random_leaf(vocabulary_, below_));
      return;
    }
    const NodeKind kind = below_(2) == 0 ? NodeKind::sequence : NodeKind::selector;
    const std::size_t children = kMinChildren + below_(std::min(shape_.max_children, free) - kMinChildren + 1);
    promised_ += children;
    const std::size_t root = nodes_.size();
    nodes_.push_back(Node::composite(kind, 1));
    for (std::size_t child = 0; child < children; ++child) {
      grow(depth + 1, false);
    }
    nodes_[root].extent = static_cast<std::uint16_t>(nodes_.size() - root);
  }

  std::vector<Node> take() { return std::move(nodes_); }

 private:
  static constexpr std::size_t kMinChildren = 2;

  const Vocabulary& vocabulary_;
  TreeShape shape_;
  const Below& below_;
  std::vector<Node> nodes_;
  std::size_t promised_ = 1;  // nodes drawn or certain to come: every open place takes at least one
};

// Nodes and conditions that a place may have, or must leave to what is certain to come.
struct Room {
  std::size_t nodes = 0;
  std::size_t conditions = 0;
};

class GuardedGrowth {
 public:
  GuardedGrowth(const Vocabulary& vocabulary, const TreeShape& shape, const Below& below)
      : vocabulary_(vocabulary), shape_(shape), below_(below) {}

  // What acts: an action or a selector of branches.
  void grow(std::size_t depth, Room kept, bool composite_wanted) {
    const Room free{shape_.max_nodes - used_.nodes - kept.nodes,
                    shape_.max_conditions - used_.conditions - kept.conditions};
    const std::size_t most = std::min({shape_.max_children - 1, free.conditions,
                                       free.nodes < kLeast ? std::size_t{0} : (free.nodes - 2) / kBranch.nodes});
    if (depth + 2 > shape_.max_depth || most == 0 || !(composite_wanted || below_(3) == 0)) {
      put(random_action(vocabulary_, below_));
      return;
    }
    const std::size_t selector = begin(NodeKind::selector);
    std::size_t branches = 1 + below_(most);
    kept.nodes += 1;  // the action at the end
    for (; branches > 0; --branches) {
      const Room later{kept.nodes + (branches - 1) * kBranch.nodes, kept.conditions + (branches - 1)};
      const std::size_t sequence = begin(NodeKind::sequence);
      put(random_condition(vocabulary_, below_));
      if (shape_.max_children > 2 && used_.nodes + later.nodes + 1 < shape_.max_nodes &&
          used_.conditions + later.conditions < shape_.max_conditions && below_(2) == 0) {
        put(random_condition(vocabulary_, below_));
      }
      grow(depth + 2, later, false);
      end(sequence);
    }
    put(random_action(vocabulary_, below_));
    end(selector);
  }

  std::vector<Node> take() { return std::move(nodes_); }

 private:
  static constexpr Room kBranch{3, 1};      // (sequence condition action)
  static constexpr std::size_t kLeast = 5;  // nodes of a selector of one branch and an action

  void put(const Node& leaf) {
    nodes_.push_back(leaf);
    ++used_.nodes;
    used_.conditions += leaf.kind == NodeKind::condition ? 1 : 0;
  }
  std::size_t begin(NodeKind kind) {
    nodes_.push_back(Node::composite(kind, 1));
    ++used_.nodes;
    return nodes_.size() - 1;
  }
  void end(std::size_t composite) { nodes_[composite].extent = static_cast<std::uint16_t>(nodes_.size() - composite); }

  const Vocabulary& vocabulary_;
  TreeShape shape_;
  const Below& below_;
  std::vector<Node> nodes_;
  Room used_;
};

}  // namespace

Node random_condition(const Vocabulary& vocabulary, const Below& below) {
  const std::size_t index = below(vocabulary.features.size());
  const Feature& feature = vocabulary.features[index];
  Op op = feature.admits_equal ? Op::equal : Op::less_equal;
  if (feature.admits_equal && feature.admits_less_equal && below(2) == 1) {
    op = Op::less_equal;
  }
  return Node::condition(index, op, feature.values[below(feature.values.size())]);
}

Node random_action(const Vocabulary& vocabulary, const Below& below) {
  return action_at(below(vocabulary.actions.size()));
}

Node random_leaf(const Vocabulary& vocabulary, const Below& below) {
  return below(2) == 0 ? random_condition(vocabulary, below) : random_action(vocabulary, below);
}

Node mutated_leaf(const Node& leaf, const Vocabulary& vocabulary, const Below& below) {
  COPPICE_CHECK(leaf.is_leaf());
  if (leaf.kind == NodeKind::action) {
    const std::size_t actions = vocabulary.actions.size();
    return actions == 1 ? leaf : action_at((leaf.index + 1 + below(actions - 1)) % actions);
  }
  Node drawn = random_condition(vocabulary, below);
  for (int redraw = 0; redraw < kMutationDraws && drawn == leaf; ++redraw) {
    drawn = random_condition(vocabulary, below);
  }
  return drawn;
}

Tree grow_tree(const Vocabulary& vocabulary, const TreeShape& shape, bool composite_root, const Below& below) {
  COPPICE_CHECK(shape.max_children >= 2 && shape.max_depth <= kMaxTreeDepth);
  Growth growth(vocabulary, shape, below);
  growth.grow(0, composite_root);
  Result<Tree> tree = Tree::from_nodes(growth.take());
  COPPICE_CHECK(tree.has_value());
  return *std::move(tree);
}

Tree grow_guarded_tree(const Vocabulary& vocabulary, const TreeShape& shape, const Below& below) {
  COPPICE_CHECK(shape.max_children >= 2 && shape.max_depth <= kMaxTreeDepth && shape.max_nodes >= 1);
  GuardedGrowth growth(vocabulary, shape, below);
  growth.grow(0, {}, true);
  Result<Tree> tree = Tree::from_nodes(growth.take());
  COPPICE_CHECK(tree.has_value());
  return *std::move(tree);
}

}  // namespace coppice
