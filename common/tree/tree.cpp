#include "common/tree/tree.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>

#include "common/check.hpp"

namespace coppice {

std::size_t depth_of_nodes(std::span<const Node> nodes) {
  std::array<std::size_t, kMaxTreeDepth + 1> open;  // ends of the composites around node i
  std::size_t depth = 0;                            // how many they are
  std::size_t deepest = 0;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    while (depth > 0 && open[depth - 1] <= i) {
      --depth;
    }
    deepest = std::max(deepest, depth);
    if (nodes[i].is_composite()) {
      COPPICE_CHECK(depth < open.size());
      open[depth++] = i + nodes[i].extent;
    }
  }
  return deepest;
}

std::size_t child_count(std::span<const Node> subtree) {
  std::size_t count = 0;
  if (subtree.front().is_composite()) {
    for (std::size_t child = 1; child < subtree.front().extent; child += subtree[child].extent) {
      ++count;
    }
  }
  return count;
}

Result<Tree> Tree::from_nodes(std::vector<Node> nodes) {
  if (nodes.empty() || nodes.size() > kMaxTreeNodes) {
    return bad_input(fmt::format("tree has {} nodes: expected 1 to {}", nodes.size(), kMaxTreeNodes));
  }
  if (nodes.front().extent != nodes.size()) {
    return bad_input(
        fmt::format("tree's root spans {} nodes of {}: expected one tree", nodes.front().extent, nodes.size()));
  }
  std::array<std::size_t, kMaxTreeDepth + 1> open;  // ends of the composites around node i
  std::size_t depth = 0;                            // how many they are
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const Node& node = nodes[i];
    while (depth > 0 && open[depth - 1] <= i) {
      --depth;
    }
    const std::size_t end = i + node.extent;
    if (node.extent == 0 || end > (depth == 0 ? nodes.size() : open[depth - 1])) {
      return bad_input(fmt::format("node {} spans {} nodes, which leaves its parent", i, node.extent));
    }
    if (depth > kMaxTreeDepth) {
      return bad_input(fmt::format("tree is deeper than {} edges at node {}", kMaxTreeDepth, i));
    }
    if (node.is_leaf() && node.extent != 1) {
      return bad_input(fmt::format("node {} is a leaf but spans {} nodes", i, node.extent));
    }
    if (node.is_composite() && node.extent == 1) {
      return bad_input(fmt::format("node {} is a composite without children: expected 1 or more", i));
    }
    if (node.is_composite()) {
      open[depth++] = end;
    }
  }
  return Tree(std::move(nodes));
}

std::size_t Tree::depth() const { return depth_of_nodes(nodes_); }

std::size_t Tree::depth_of(std::size_t i) const {
  COPPICE_CHECK(i < nodes_.size());
  std::size_t depth = 0;
  for (std::size_t ancestor = 0; ancestor < i; ++ancestor) {
    if (ancestor + nodes_[ancestor].extent > i) {
      ++depth;
    }
  }
  return depth;
}

std::span<const Node> Tree::subtree(std::size_t i) const {
  COPPICE_CHECK(i < nodes_.size());
  return std::span<const Node>(nodes_).subspan(i, nodes_[i].extent);
}

Tree Tree::with_subtree(std::size_t i, std::span<const Node> replacement) const {
  COPPICE_CHECK(i < nodes_.size());
  const std::size_t removed = nodes_[i].extent;
  COPPICE_CHECK(nodes_.size() - removed + replacement.size() <= kMaxTreeNodes);
  std::vector<Node> result;
  result.reserve(nodes_.size() - removed + replacement.size());
  result.insert(result.end(), nodes_.begin(), nodes_.begin() + static_cast<std::ptrdiff_t>(i));
  for (std::size_t ancestor = 0; ancestor < i; ++ancestor) {
    if (ancestor + nodes_[ancestor].extent > i) {
      result[ancestor].extent = static_cast<std::uint16_t>(nodes_[ancestor].extent - removed + replacement.size());
    }
  }
  result.insert(result.end(), replacement.begin(), replacement.end());
  result.insert(result.end(), nodes_.begin() + static_cast<std::ptrdiff_t>(i + removed), nodes_.end());
  return Tree(std::move(result));
}

Result<void> check_tree(const Tree& tree, const Vocabulary& vocabulary) {
  for (std::size_t i = 0; i < tree.size(); ++i) {
    const Node& node = tree[i];
    if (node.kind == NodeKind::action && node.index >= vocabulary.actions.size()) {
      return bad_input(
          fmt::format("node {} has action {}: expected 0 to {}", i, node.index, vocabulary.actions.size() - 1));
    }
    if (node.kind != NodeKind::condition) {
      continue;
    }
    if (node.index >= vocabulary.features.size()) {
      return bad_input(
          fmt::format("node {} tests feature {}: expected 0 to {}", i, node.index, vocabulary.features.size() - 1));
    }
    const Feature& feature = vocabulary.features[node.index];
    if (!feature.admits(node.op)) {
      return bad_input(fmt::format("node {}: feature '{}' does not admit operator '{}'", i, feature.name,
                                   node.op == Op::equal ? "=" : "<="));
    }
    // Linear: features have few values, and this is done for every condition that travels.
    if (std::find(feature.values.begin(), feature.values.end(), node.value) == feature.values.end()) {
      return bad_input(fmt::format("node {}: feature '{}' never reads {}: expected one of {}", i, feature.name,
                                   node.value, fmt::join(feature.values, ", ")));
    }
  }
  return {};
}

}  // namespace coppice
