// A behaviour tree as a value: one flat vector of nodes in prefix order, each knowing its extent, so that a
// subtree is a contiguous span and crossover is three copies (the representation of Operon, heal-research).
// Invariant: well formed (every composite has a child, extents add up) and within kMaxTreeNodes and
// kMaxTreeDepth. A tree does not know its vocabulary; check_tree() holds it against one. Copyable; const
// members are safe from any thread.
#pragma once

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "common/error.hpp"
#include "common/tree/node.hpp"

namespace coppice {

class Tree {
 public:
  // One action leaf.
  explicit Tree(ActionId action) : nodes_{Node::action(action)} {}

  // Errors: nodes empty or too many, extents that do not add up, a composite without children, too deep.
  static Result<Tree> from_nodes(std::vector<Node> nodes);

  // Gives up the nodes, so that their memory can be used again.
  std::vector<Node> take_nodes() && { return std::move(nodes_); }

  std::size_t size() const { return nodes_.size(); }
  std::span<const Node> nodes() const { return nodes_; }
  const Node& operator[](std::size_t i) const { return nodes_[i]; }

  // Edges from the root to the deepest leaf; a single leaf has depth 0.
  std::size_t depth() const;

  // Edges from the root to node i. REQUIRES: i < size().
  std::size_t depth_of(std::size_t i) const;

  // The subtree whose root is node i. REQUIRES: i < size().
  std::span<const Node> subtree(std::size_t i) const;

  // The same tree with the subtree at node i replaced. REQUIRES: i < size(), replacement is a well-formed
  // subtree, or empty where i has a sibling, and the result keeps the limits.
  Tree with_subtree(std::size_t i, std::span<const Node> replacement) const;

  bool operator==(const Tree&) const = default;

 private:
  explicit Tree(std::vector<Node> nodes) : nodes_(std::move(nodes)) {}

  std::vector<Node> nodes_;
};

// Edges from the root of a prefix-ordered subtree to its deepest leaf. REQUIRES: well formed.
std::size_t depth_of_nodes(std::span<const Node> nodes);

// Number of children of a composite at the front of a prefix-ordered subtree; 0 for a leaf.
std::size_t child_count(std::span<const Node> subtree);

// Whether the tree speaks only of this vocabulary. Errors name the node (prefix index) and what was expected.
// A value outside a feature's declared values is an error: it would be a condition that is never true.
Result<void> check_tree(const Tree& tree, const Vocabulary& vocabulary);

}  // namespace coppice
