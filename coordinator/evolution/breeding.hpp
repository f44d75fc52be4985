// The genetic operators (thesis III-D): from parents and chance to children. Invariant: given parents within the limits
// (shape, kMaxTreeNodes, the vocabulary), every child is within them; that is checked on each child. Const; a Stream
// belongs to its caller, so one Breeding serves any number of threads.
#pragma once

#include <utility>

#include "common/chain/random.hpp"
#include "common/tree/random_tree.hpp"
#include "common/tree/tree.hpp"

namespace coppice {

class Breeding {
 public:
  // The vocabulary must outlive it. REQUIRES: shape.max_children >= 2, shape.max_depth <= kMaxTreeDepth.
  Breeding(const Vocabulary& vocabulary, const TreeShape& shape);

  // A new individual whose root is a composite, if the limits allow one.
  Tree grow(Stream& stream) const;

  // Swaps a subtree of `a` for one of `b`: a uniform node of `a`, and a uniform one among those nodes of `b` that leave
  // both children within the limits. REQUIRES: a and b within the limits.
  std::pair<Tree, Tree> crossover(Stream& stream, const Tree& a, const Tree& b) const;

  // Micro mutation: a uniform leaf gets new parameters.
  Tree mutate_leaf(Stream& stream, const Tree& tree) const;

  // Macro mutation, "headless chicken crossover": a uniform node is replaced by a grown subtree.
  Tree mutate_subtree(Stream& stream, const Tree& tree) const;

  // Depth, number of nodes, 2 to max_children children of every composite, and the vocabulary.
  bool within_limits(const Tree& tree) const;

 private:
  Tree checked(Tree tree) const;

  const Vocabulary& vocabulary_;
  TreeShape shape_;
};

}  // namespace coppice
