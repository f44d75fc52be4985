// A tree while it is edited: its nodes in prefix order, as in a Tree, so that every change is a move within one small
// block of memory and allocates nothing. Between two changes it need not be a tree: a composite may have no children.
// A place is the index of a node, valid until the next change. Where a change has to keep hold of its parts, TreeDraft
// is simpler; this one is for the operators that breed.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "common/tree/tree.hpp"

namespace coppice {

class FlatDraft {
 public:
  explicit FlatDraft(std::span<const Node> tree) { assign(tree); }

  // Begins anew, in the memory that it has.
  void assign(std::span<const Node> tree);

  std::size_t size() const { return nodes_.size(); }
  std::span<const Node> nodes() const { return nodes_; }
  const Node& operator[](std::size_t place) const { return nodes_[place]; }
  std::span<const Node> subtree(std::size_t place) const { return nodes().subspan(place, nodes_[place].extent); }
  std::size_t children(std::size_t place) const { return child_count(subtree(place)); }

  // REQUIRES: the node at the place and the new one are both leaves, or both composites; its extent is kept.
  void replace(std::size_t place, Node node);
  // Puts a subtree in as child number `child` of a composite. REQUIRES: child <= children(place); the subtree is no
  // part of this draft.
  void insert(std::size_t place, std::size_t child, std::span<const Node> subtree);
  // Takes the subtree out. REQUIRES: not the root.
  void remove(std::size_t place);
  // A composite takes the place, with what stood there and a new sibling before or behind it as its children.
  void wrap(std::size_t place, NodeKind kind, std::span<const Node> sibling, bool sibling_first);
  // REQUIRES: a < b < children(place).
  void swap_children(std::size_t place, std::size_t a, std::size_t b);

  // Composites without children go, those with one child become it, and those of their parent's kind become its
  // children: tick() stays the same. The root, too, becomes its only child; it may be left without any.
  void tidy();

  // None: a composite without children, or beyond the limits of every tree.
  std::optional<Tree> finished() const;

 private:
  std::size_t child_at(std::size_t place, std::size_t child) const;
  // Every node around `place`, itself left out, spans so many more nodes.
  void lengthen_around(std::size_t place, std::ptrdiff_t nodes);
  struct Tidied;
  Tidied tidy_from(std::size_t from, std::size_t to, std::optional<NodeKind> parent);

  std::vector<Node> nodes_;
};

}  // namespace coppice
