// Trees by chance: the "grow" method of genetic programming (Koza 1992), used to initialise a population, by macro
// mutation, and by property tests. The draws come in as a function, so that this library knows no generator.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>

#include "common/tree/tree.hpp"

namespace coppice {

struct TreeShape {
  std::size_t max_depth = 3;     // D_d of thesis Table III, in edges from the root
  std::size_t max_children = 4;  // D_c of thesis Table III
  std::size_t max_nodes = kMaxTreeNodes;
  std::size_t max_conditions = kMaxTreeNodes;  // grow_tree() does not look at it; grow_guarded_tree() does
  bool guarded = false;                        // as is_guarded(); the same
};

// Uniform in [0, n) for n > 0.
using Below = std::function<std::uint64_t(std::uint64_t n)>;

// A condition (uniform feature, admitted operator, declared value) or an action, evenly.
Node random_leaf(const Vocabulary& vocabulary, const Below& below);
Node random_condition(const Vocabulary& vocabulary, const Below& below);
Node random_action(const Vocabulary& vocabulary, const Below& below);

// Another leaf of the same kind: a condition gets a new feature, operator and value; an action a new action.
Node mutated_leaf(const Node& leaf, const Vocabulary& vocabulary, const Below& below);

// A tree of depth at most shape.max_depth whose composites have 2 to shape.max_children children: at each place above
// the limit a composite or a leaf is drawn, at the limit a leaf. With `composite_root` the root is a composite if the
// limits allow it. REQUIRES: max_children >= 2, max_depth <= kMaxTreeDepth, 1 <= max_nodes <= kMaxTreeNodes.
Tree grow_tree(const Vocabulary& vocabulary, const TreeShape& shape, bool composite_root, const Below& below);

// The same in guarded form (guard.hpp): a selector of branches, each a sequence of one or two conditions and an action
// or another such selector, and an action at the end; an action where the limits leave no room. REQUIRES: as
// grow_tree().
Tree grow_guarded_tree(const Vocabulary& vocabulary, const TreeShape& shape, const Below& below);

}  // namespace coppice
