// Pruning (thesis Appendix A, Listings A.1 to A.4): smaller trees that mean the same, with a reason for every node
// removed.
#pragma once

#include <string>
#include <vector>

#include "common/tree/state_columns.hpp"
#include "common/tree/tree.hpp"

namespace coppice {

struct Removal {
  std::string what;       // text of the subtree that went, or of the composite that was dissolved
  std::string reason;     // one clause: "never reached: it follows an action in a selector"
  std::size_t nodes = 0;  // how many nodes fewer the tree has
};

struct Simplified {
  Tree tree;
  std::vector<Removal> removals;  // in the order in which they were made
};

// Sound for every observation that the vocabulary allows, whether a chain has seen it or not: tick() is unchanged
// on the whole feature space. Rules: nodes after an action (or after anything that always succeeds) in a selector; an
// action overwritten later in the same sequence with nothing between that can fail; composites with one child;
// conditions already decided by what was tested on the path; nested composites of one kind; a trailing or leading node
// that changes nothing. Idempotent. REQUIRES: check_tree(tree, vocabulary).
Simplified simplify(const Tree& tree, const Vocabulary& vocabulary);

// Also removes every node whose removal leaves the action table on these states unchanged (and hoists a composite's
// only useful child). Not sound for states that the chain has never seen. The result has the same action table and
// passes simplify(tree, vocabulary) unchanged. REQUIRES: check_tree(tree, vocabulary), columns of that vocabulary.
Simplified simplify(const Tree& tree, const Vocabulary& vocabulary, const StateColumns& columns);

}  // namespace coppice
