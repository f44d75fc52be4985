// A tree being taken apart and put together: nodes that own their children, where a Tree is a flat value. For operators
// that move several parts at once. Not checked; finished() says whether it has become a tree.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "common/tree/tree.hpp"

namespace coppice {

struct TreeDraft {
  Node node;  // its extent means nothing here
  std::vector<TreeDraft> children = {};

  static TreeDraft of(std::span<const Node> subtree);

  // Every place in prefix order, with its parent (null: the root). Valid until the draft is changed.
  struct Place {
    TreeDraft* draft;
    TreeDraft* parent;
    std::size_t index() const { return static_cast<std::size_t>(draft - parent->children.data()); }
  };
  std::vector<Place> places();

  void insert(std::size_t at, TreeDraft child) {
    children.insert(children.begin() + static_cast<std::ptrdiff_t>(at), std::move(child));
  }
  void remove(std::size_t at) { children.erase(children.begin() + static_cast<std::ptrdiff_t>(at)); }

  // Below this one: composites without children go, those with one child become it, and those of their parent's kind
  // become its children: tick() stays the same. The root, too, becomes its only child.
  void tidy();

  // None: a composite without children, or beyond the limits of every tree.
  std::optional<Tree> finished() const;
};

}  // namespace coppice
