#include "coordinator/evolution/breeding.hpp"

#include <algorithm>
#include <vector>

#include "common/check.hpp"

namespace coppice {
namespace {

Below draws_of(Stream& stream) {
  return [&stream](std::uint64_t n) { return stream.below(n); };
}

// Where a node stands in its tree.
struct Place {
  std::size_t depth = 0;   // edges from the root
  std::size_t height = 0;  // edges to its deepest leaf
};

std::vector<Place> places_of(const Tree& tree) {
  std::vector<Place> places(tree.size());
  std::vector<std::size_t> ancestors;
  for (std::size_t i = 0; i < tree.size(); ++i) {
    while (!ancestors.empty() && ancestors.back() + tree[ancestors.back()].extent <= i) {
      ancestors.pop_back();
    }
    places[i].depth = ancestors.size();
    for (const std::size_t ancestor : ancestors) {
      places[ancestor].height = std::max(places[ancestor].height, places[i].depth - places[ancestor].depth);
    }
    ancestors.push_back(i);
  }
  return places;
}

}  // namespace

Breeding::Breeding(const Vocabulary& vocabulary, const TreeShape& shape)
    : vocabulary_(vocabulary), shape_(shape), checker_(vocabulary) {
  COPPICE_CHECK(shape.max_children >= 2 && shape.max_depth <= kMaxTreeDepth && shape.max_nodes >= 1 &&
                shape.max_nodes <= kMaxTreeNodes);
}

Tree Breeding::grow(Stream& stream) const { return checked(grow_tree(vocabulary_, shape_, true, draws_of(stream))); }

std::pair<Tree, Tree> Breeding::crossover(Stream& stream, const Tree& a, const Tree& b) const {
  const std::vector<Place> in_a = places_of(a);
  const std::vector<Place> in_b = places_of(b);
  const std::size_t cut = stream.below(a.size());
  const std::size_t cut_nodes = a[cut].extent;
  // A swap of nodes keeps the number of children, so depth and size decide. Depth always leaves some node: on the way
  // from b's root to its deepest leaf there is one deep enough and high enough.
  std::vector<std::size_t> partners;
  for (std::size_t i = 0; i < b.size(); ++i) {
    const std::size_t nodes = b[i].extent;
    if (in_a[cut].depth + in_b[i].height <= shape_.max_depth && in_b[i].depth + in_a[cut].height <= shape_.max_depth &&
        a.size() - cut_nodes + nodes <= shape_.max_nodes && b.size() - nodes + cut_nodes <= shape_.max_nodes) {
      partners.push_back(i);
    }
  }
  if (partners.empty()) {  // only near the largest number of nodes: swap the roots
    return {b, a};
  }
  const std::size_t partner = partners[stream.below(partners.size())];
  return {checked(a.with_subtree(cut, b.subtree(partner))), checked(b.with_subtree(partner, a.subtree(cut)))};
}

Tree Breeding::mutate_leaf(Stream& stream, const Tree& tree) const {
  std::vector<std::size_t> leaves;
  for (std::size_t i = 0; i < tree.size(); ++i) {
    if (tree[i].is_leaf()) {
      leaves.push_back(i);
    }
  }
  const std::size_t chosen = leaves[stream.below(leaves.size())];
  const Node leaf = mutated_leaf(tree[chosen], vocabulary_, draws_of(stream));
  return checked(tree.with_subtree(chosen, {&leaf, 1}));
}

Tree Breeding::mutate_subtree(Stream& stream, const Tree& tree) const {
  const std::size_t chosen = stream.below(tree.size());
  const std::size_t kept = tree.size() - tree[chosen].extent;
  const TreeShape room{shape_.max_depth - tree.depth_of(chosen), shape_.max_children, shape_.max_nodes - kept};
  return checked(tree.with_subtree(chosen, grow_tree(vocabulary_, room, false, draws_of(stream)).nodes()));
}

bool Breeding::within_limits(const Tree& tree) const {
  if (tree.size() > shape_.max_nodes || tree.depth() > shape_.max_depth || !checker_.admits(tree)) {
    return false;
  }
  for (std::size_t i = 0; i < tree.size(); ++i) {
    const std::size_t children = child_count(tree.subtree(i));
    if (tree[i].is_composite() && (children < 2 || children > shape_.max_children)) {
      return false;
    }
  }
  return true;
}

Tree Breeding::checked(Tree tree) const {
  COPPICE_CHECK(within_limits(tree));
  return tree;
}

}  // namespace coppice
