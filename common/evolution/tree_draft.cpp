#include "common/evolution/tree_draft.hpp"

#include <iterator>
#include <utility>

namespace coppice {
namespace {

void collect(TreeDraft& draft, TreeDraft* parent, std::vector<TreeDraft::Place>& places) {
  places.push_back({&draft, parent});
  for (TreeDraft& child : draft.children) {
    collect(child, &draft, places);
  }
}

std::size_t write(const TreeDraft& draft, std::vector<Node>& nodes) {
  const std::size_t at = nodes.size();
  nodes.push_back(draft.node);
  std::size_t extent = 1;
  for (const TreeDraft& child : draft.children) {
    extent += write(child, nodes);
  }
  nodes[at].extent = static_cast<std::uint16_t>(extent);
  return extent;
}

std::size_t size_of(const TreeDraft& draft) {
  std::size_t size = 1;
  for (const TreeDraft& child : draft.children) {
    size += size_of(child);
  }
  return size;
}

void tidy_children(TreeDraft& draft) {
  for (std::size_t i = 0; i < draft.children.size();) {
    tidy_children(draft.children[i]);
    TreeDraft& child = draft.children[i];
    if (!child.node.is_composite()) {
      ++i;
      continue;
    }
    if (child.children.empty()) {
      draft.remove(i);
      continue;
    }
    if (child.children.size() > 1 && child.node.kind != draft.node.kind) {
      ++i;
      continue;
    }
    // Tidied themselves, so the grandchildren need no further look but for their kind: the next turns give it.
    std::vector<TreeDraft> grandchildren = std::move(child.children);
    draft.remove(i);
    draft.children.insert(draft.children.begin() + static_cast<std::ptrdiff_t>(i),
                          std::make_move_iterator(grandchildren.begin()), std::make_move_iterator(grandchildren.end()));
  }
}

}  // namespace

TreeDraft TreeDraft::of(std::span<const Node> subtree) {
  TreeDraft draft{subtree.front()};
  draft.children.reserve(child_count(subtree) + 1);  // most edits put one in at the most
  for (std::size_t i = 1; i < subtree.size(); i += subtree[i].extent) {
    draft.children.push_back(of(subtree.subspan(i, subtree[i].extent)));
  }
  return draft;
}

std::vector<TreeDraft::Place> TreeDraft::places() {
  std::vector<Place> places;
  places.reserve(size_of(*this));
  collect(*this, nullptr, places);
  return places;
}

void TreeDraft::tidy() {
  tidy_children(*this);
  while (node.is_composite() && children.size() == 1) {
    TreeDraft only = std::move(children.front());
    *this = std::move(only);
  }
}

std::optional<Tree> TreeDraft::finished() const {
  if (size_of(*this) > kMaxTreeNodes) {
    return std::nullopt;
  }
  std::vector<Node> nodes;
  nodes.reserve(size_of(*this));
  write(*this, nodes);
  auto tree = Tree::from_nodes(std::move(nodes));
  return tree ? std::optional(std::move(*tree)) : std::nullopt;
}

}  // namespace coppice
