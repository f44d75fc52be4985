#include "common/evolution/flat_draft.hpp"

#include <algorithm>

#include "common/check.hpp"

namespace coppice {
namespace {

constexpr std::size_t kUsuallyAdded = 16;  // nodes that an edit puts in, at the most

std::ptrdiff_t offset(std::size_t place) { return static_cast<std::ptrdiff_t>(place); }

std::uint16_t longer(std::uint16_t extent, std::ptrdiff_t nodes) {
  return static_cast<std::uint16_t>(std::ptrdiff_t{extent} + nodes);
}

}  // namespace

void FlatDraft::assign(std::span<const Node> tree) {
  nodes_.reserve(tree.size() + kUsuallyAdded);
  nodes_.assign(tree.begin(), tree.end());
}

void FlatDraft::lengthen_around(std::size_t place, std::ptrdiff_t nodes) {
  for (std::size_t ancestor = 0; ancestor < place; ++ancestor) {
    if (ancestor + nodes_[ancestor].extent > place) {
      nodes_[ancestor].extent = longer(nodes_[ancestor].extent, nodes);
    }
  }
}

std::size_t FlatDraft::child_at(std::size_t place, std::size_t child) const {
  std::size_t at = place + 1;
  for (; child > 0; --child) {
    at += nodes_[at].extent;
  }
  return at;
}

void FlatDraft::replace(std::size_t place, Node node) {
  COPPICE_CHECK(node.is_leaf() == nodes_[place].is_leaf());
  node.extent = nodes_[place].extent;
  nodes_[place] = node;
}

void FlatDraft::insert(std::size_t place, std::size_t child, std::span<const Node> subtree) {
  COPPICE_CHECK(nodes_[place].is_composite());
  const std::size_t at = child_at(place, child);
  lengthen_around(place, std::ssize(subtree));
  nodes_[place].extent = longer(nodes_[place].extent, std::ssize(subtree));
  nodes_.insert(nodes_.begin() + offset(at), subtree.begin(), subtree.end());
}

void FlatDraft::remove(std::size_t place) {
  COPPICE_CHECK(place > 0);
  const std::size_t extent = nodes_[place].extent;
  lengthen_around(place, -offset(extent));
  nodes_.erase(nodes_.begin() + offset(place), nodes_.begin() + offset(place + extent));
}

void FlatDraft::wrap(std::size_t place, NodeKind kind, std::span<const Node> sibling, bool sibling_first) {
  const std::size_t wrapped = nodes_[place].extent;
  lengthen_around(place, 1 + std::ssize(sibling));
  nodes_.insert(nodes_.begin() + offset(place + (sibling_first ? 0 : wrapped)), sibling.begin(), sibling.end());
  nodes_.insert(nodes_.begin() + offset(place), Node::composite(kind, 1 + wrapped + sibling.size()));
}

void FlatDraft::swap_children(std::size_t place, std::size_t a, std::size_t b) {
  const auto first = nodes_.begin() + offset(child_at(place, a));
  const auto first_end = first + first->extent;
  const auto second = nodes_.begin() + offset(child_at(place, b));
  const auto second_end = second + second->extent;
  // The one behind comes to the front, then what stood between them before the other.
  const auto between = first + (second_end - second);
  const auto moved_end = std::rotate(first, second, second_end);
  COPPICE_CHECK(moved_end == between);
  std::rotate(between, between + (first_end - first), second_end);
}

// What tidying a subtree came to.
struct FlatDraft::Tidied {
  std::size_t read = 0;     // where what comes after it is read
  std::size_t written = 0;  // where what comes after it is written
};

// Reads a subtree at `from` and writes it at `to`, which is never behind; nothing that is still to be read is
// overwritten, because tidying adds no nodes.
FlatDraft::Tidied FlatDraft::tidy_from(std::size_t from, std::size_t to, std::optional<NodeKind> parent) {
  const Node node = nodes_[from];
  const std::size_t end = from + node.extent;
  nodes_[to] = node;
  if (node.is_leaf()) {
    return {end, to + 1};
  }
  std::size_t children = 0;
  Tidied next{from + 1, to + 1};
  while (next.read < end) {
    next = tidy_from(next.read, next.written, node.kind);
  }
  for (std::size_t child = to + 1; child < next.written; child += nodes_[child].extent) {
    ++children;
  }
  nodes_[to].extent = static_cast<std::uint16_t>(next.written - to);
  const bool is_root = !parent.has_value();
  if (children == 0 && !is_root) {
    return {end, to};
  }
  // Dissolved: its children move up, and what is then of the parent's kind dissolves as well.
  const auto drop_head = [&](std::size_t head) {
    std::move(nodes_.begin() + offset(head + 1), nodes_.begin() + offset(next.written), nodes_.begin() + offset(head));
    --next.written;
  };
  if (children == 1 || (!is_root && node.kind == *parent)) {
    drop_head(to);
    if (children == 1 && !is_root && nodes_[to].kind == *parent) {
      drop_head(to);
    }
  }
  return {end, next.written};
}

void FlatDraft::tidy() { nodes_.resize(tidy_from(0, 0, std::nullopt).written); }

std::optional<Tree> FlatDraft::finished() const {
  auto tree = Tree::from_nodes(std::vector<Node>(nodes_));
  return tree ? std::optional(std::move(*tree)) : std::nullopt;
}

}  // namespace coppice
