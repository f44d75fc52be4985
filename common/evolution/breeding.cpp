#include "common/evolution/breeding.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory_resource>
#include <vector>

#include "common/check.hpp"
#include "common/evolution/flat_draft.hpp"
#include "common/tree/guard.hpp"
#include "common/tree/tree_size.hpp"

namespace coppice {
namespace {

Below draws_of(Stream& stream) {
  return [&stream](std::uint64_t n) { return stream.below(n); };
}

// Where a node stands in its tree.
struct Place {
  std::size_t depth = 0;       // edges from the root
  std::size_t height = 0;      // edges to its deepest leaf
  std::size_t conditions = 0;  // in its subtree
  bool acts = false;           // so does something in its subtree
};

// Memory for the lists of one operator: of most trees they fit on the stack.
class Scratch {
 public:
  std::pmr::memory_resource* memory() { return &memory_; }

 private:
  std::array<std::byte, 8192> room_;
  std::pmr::monotonic_buffer_resource memory_{room_.data(), room_.size()};
};

std::pmr::vector<Place> places_of(const Tree& tree, Scratch& scratch) {
  std::pmr::vector<Place> places(tree.size(), scratch.memory());
  std::array<std::size_t, kMaxTreeDepth + 1> around;  // the node itself and those that it is part of
  std::size_t depth = 0;
  for (std::size_t i = 0; i < tree.size(); ++i) {
    while (depth > 0 && around[depth - 1] + tree[around[depth - 1]].extent <= i) {
      --depth;
    }
    places[i].depth = depth;
    around[depth++] = i;
    for (std::size_t a = 0; a < depth; ++a) {
      Place& place = places[around[a]];
      place.height = std::max(place.height, depth - 1 - a);
      place.conditions += tree[i].kind == NodeKind::condition ? 1 : 0;
      place.acts = place.acts || tree[i].kind == NodeKind::action;
    }
  }
  return places;
}

}  // namespace

Breeding::Breeding(const Vocabulary& vocabulary, const TreeShape& shape)
    : vocabulary_(vocabulary), shape_(shape), checker_(vocabulary) {
  COPPICE_CHECK(shape.max_children >= 2 && shape.max_depth <= kMaxTreeDepth && shape.max_nodes >= 1 &&
                shape.max_nodes <= kMaxTreeNodes);
}

Tree Breeding::grown(Stream& stream, const TreeShape& room, bool composite_root) const {
  return shape_.guarded ? grow_guarded_tree(vocabulary_, room, draws_of(stream))
                        : grow_tree(vocabulary_, room, composite_root, draws_of(stream));
}

Tree Breeding::grow(Stream& stream) const { return checked(trimmed(stream, grown(stream, shape_, true))); }

Tree Breeding::trimmed(Stream& stream, Tree tree) const {
  const std::size_t conditions = condition_count(tree.nodes());
  if (conditions <= shape_.max_conditions) {
    return tree;
  }
  FlatDraft draft(tree.nodes());
  for (std::size_t more = conditions - shape_.max_conditions; more > 0; --more) {
    std::uint64_t chosen = stream.below(condition_count(draft.nodes()));
    std::size_t place = 0;
    while (draft[place].kind != NodeKind::condition || chosen-- > 0) {
      ++place;
    }
    if (place > 0) {
      draft.remove(place);
      draft.tidy();
    }
    if (place == 0 || (draft.size() == 1 && draft[0].is_composite())) {  // nothing was there but conditions
      return Tree(random_action(vocabulary_, draws_of(stream)).action());
    }
  }
  auto smaller = draft.finished();
  COPPICE_CHECK(smaller.has_value());
  // Composites that were dissolved may have left their parent with too many children.
  return within_limits(*smaller) ? *std::move(smaller) : Tree(random_action(vocabulary_, draws_of(stream)).action());
}

std::optional<Breeding::Cuts> Breeding::draw_cuts(Stream& stream, const Tree& a, const Tree& b) const {
  Scratch scratch;
  const auto in_a = places_of(a, scratch);
  const auto in_b = places_of(b, scratch);
  const std::size_t cut = stream.below(a.size());
  const std::size_t cut_nodes = a[cut].extent;
  // A swap of nodes keeps the number of children, so depth and size decide. Depth always leaves some node: on the way
  // from b's root to its deepest leaf there is one deep enough and high enough.
  std::pmr::vector<std::size_t> partners(scratch.memory());
  partners.reserve(b.size());
  for (std::size_t i = 0; i < b.size(); ++i) {
    const std::size_t nodes = b[i].extent;
    if (in_a[cut].depth + in_b[i].height <= shape_.max_depth && in_b[i].depth + in_a[cut].height <= shape_.max_depth &&
        a.size() - cut_nodes + nodes <= shape_.max_nodes && b.size() - nodes + cut_nodes <= shape_.max_nodes &&
        in_a[0].conditions - in_a[cut].conditions + in_b[i].conditions <= shape_.max_conditions &&
        in_b[0].conditions - in_b[i].conditions + in_a[cut].conditions <= shape_.max_conditions &&
        (!shape_.guarded || in_a[cut].acts == in_b[i].acts)) {
      partners.push_back(i);
    }
  }
  if (partners.empty()) {
    return std::nullopt;
  }
  return Cuts{cut, partners[stream.below(partners.size())]};
}

std::pair<Tree, Tree> Breeding::crossover(Stream& stream, const Tree& a, const Tree& b) const {
  const auto cuts = draw_cuts(stream, a, b);
  if (!cuts) {  // only near the largest number of nodes: swap the roots
    return {b, a};
  }
  return {checked(a.with_subtree(cuts->in_a, b.subtree(cuts->in_b))),
          checked(b.with_subtree(cuts->in_b, a.subtree(cuts->in_a)))};
}

Tree Breeding::crossover_one(Stream& stream, const Tree& a, const Tree& b) const {
  const auto cuts = draw_cuts(stream, a, b);
  return cuts ? checked(a.with_subtree(cuts->in_a, b.subtree(cuts->in_b))) : b;
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
  TreeShape room = shape_;
  room.max_depth -= tree.depth_of(chosen);
  room.max_nodes -= kept;
  const std::span<const Node> old = tree.subtree(chosen);
  if (shape_.guarded && action_count(old) == 0) {  // what asked goes on asking
    const Node condition = random_condition(vocabulary_, draws_of(stream));
    return checked(tree.with_subtree(chosen, {&condition, 1}));
  }
  room.max_conditions -= condition_count(tree.nodes()) - condition_count(old);
  return checked(trimmed(stream, tree.with_subtree(chosen, grown(stream, room, false).nodes())));
}

bool Breeding::within_limits(const Tree& tree) const {
  if (tree.size() > shape_.max_nodes || tree.depth() > shape_.max_depth || !checker_.admits(tree) ||
      condition_count(tree.nodes()) > shape_.max_conditions || (shape_.guarded && !is_guarded(tree))) {
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
