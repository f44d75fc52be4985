#include "coordinator/trust/jumps.hpp"

namespace coppice {

std::size_t first_leaf(const Tree& tree, std::size_t node) {
  while (tree[node].is_composite()) {
    ++node;
  }
  return node;
}

std::vector<Jump> jumps_of(const Tree& tree) {
  std::vector<Jump> jumps(tree.size());
  // Prefix order: a composite's own jumps are known before those of its children.
  for (std::size_t node = 0; node < tree.size(); ++node) {
    if (!tree[node].is_composite()) {
      continue;
    }
    const Jump after = jumps[node];
    const std::size_t end = node + tree[node].extent;
    for (std::size_t child = node + 1; child < end; child += tree[child].extent) {
      const std::size_t sibling = child + tree[child].extent;
      jumps[child] = after;
      if (sibling < end) {
        (tree[node].kind == NodeKind::sequence ? jumps[child].on_success : jumps[child].on_failure) =
            first_leaf(tree, sibling);
      }
    }
  }
  return jumps;
}

std::size_t last_writer(const Tree& tree, std::span<const Jump> jumps, std::span<const std::uint8_t> features) {
  std::size_t writer = kTickEnds;
  for (std::size_t leaf = first_leaf(tree, 0); leaf != kTickEnds;) {
    const Node& node = tree[leaf];
    const bool succeeded = node.kind == NodeKind::action || holds(node, features[node.index]);
    writer = node.kind == NodeKind::action ? leaf : writer;
    leaf = succeeded ? jumps[leaf].on_success : jumps[leaf].on_failure;
  }
  return writer;
}

}  // namespace coppice
