// The genetic operators (thesis III-D): from parents and chance to children. Invariant: given parents within the limits
// (shape, the vocabulary), every child is within them; that is checked on each child. Where the limits ask for guarded
// trees (guard.hpp), the operators make no others: what asks is only put where something asked. Const; a Stream
// belongs to its caller, so one Breeding serves any number of threads.
#pragma once

#include <optional>
#include <utility>

#include "common/chain/random.hpp"
#include "common/tree/random_tree.hpp"
#include "common/tree/tree.hpp"
#include "common/tree/tree_checker.hpp"

namespace coppice {

class Breeding {
 public:
  // The vocabulary must outlive it. REQUIRES: shape.max_children >= 2, shape.max_depth <= kMaxTreeDepth,
  // 1 <= shape.max_nodes <= kMaxTreeNodes.
  Breeding(const Vocabulary& vocabulary, const TreeShape& shape);

  // A new individual whose root is a composite, if the limits allow one. What has too many conditions loses some.
  Tree grow(Stream& stream) const;

  // Swaps a subtree of `a` for one of `b`: a uniform node of `a`, and a uniform one among those nodes of `b` that leave
  // both children within the limits. REQUIRES: a and b within the limits.
  std::pair<Tree, Tree> crossover(Stream& stream, const Tree& a, const Tree& b) const;
  // The first of those two, with the same draws.
  Tree crossover_one(Stream& stream, const Tree& a, const Tree& b) const;

  // Micro mutation: a uniform leaf gets new parameters.
  Tree mutate_leaf(Stream& stream, const Tree& tree) const;

  // Macro mutation, "headless chicken crossover": a uniform node is replaced by a grown subtree, and the tree then
  // loses conditions beyond the limit.
  Tree mutate_subtree(Stream& stream, const Tree& tree) const;

  // A few small changes at random places: a leaf or the kind of a composite is changed; a leaf, or a sequence of
  // conditions and an action, is put in; a subtree is taken out, moved, or wrapped with a leaf; two siblings swap
  // places. Then composites with one child, or of their parent's kind, are dissolved. The tree itself where no attempt
  // stayed within the limits and changed it.
  Tree edit(Stream& stream, const Tree& tree) const;

  // simplify() that holds in every possible state; the tree itself if that left the limits, which it can only by
  // max_children.
  Tree simplified(const Tree& tree) const;

  // Depth, number of nodes and of conditions, 2 to max_children children of every composite, guarded form if wanted,
  // and the vocabulary.
  bool within_limits(const Tree& tree) const;

 private:
  struct Cuts {
    std::size_t in_a = 0;
    std::size_t in_b = 0;
  };
  // None: no node of b leaves both children within the limits.
  std::optional<Cuts> draw_cuts(Stream& stream, const Tree& a, const Tree& b) const;
  Tree checked(Tree tree) const;
  // Without so many conditions, drawn uniformly, that the limit holds.
  Tree trimmed(Stream& stream, Tree tree) const;
  Tree grown(Stream& stream, const TreeShape& room, bool composite_root) const;

  const Vocabulary& vocabulary_;
  TreeShape shape_;
  TreeChecker checker_;
};

}  // namespace coppice
