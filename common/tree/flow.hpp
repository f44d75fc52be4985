// What can be said about every node of a tree without running it, for simplify(). Forwards: which values each feature
// can still have where the node is reached, which statuses it can return, which actions can be on the blackboard
// then. Backwards: whether what is written there lasts. Values, computed once per tree; a changed tree needs a new one.
#pragma once

#include <bitset>
#include <cstddef>
#include <vector>

#include "common/tree/tree.hpp"

namespace coppice {

// Whether conditions are decided by what was tested on the path and by the values that a feature can have at all, or
// every condition is taken to go either way. The second knows less, but stays true when conditions are removed.
enum class Facts { used, ignored };

// What a tick writes from some point to its end, on every way there is.
struct Outcome {
  enum class Kind { nothing, action, differs };
  Kind kind = Kind::nothing;
  ActionId action = kNoAction;  // Kind::action: the last one written
  bool operator==(const Outcome&) const = default;
};

struct NodeFlow {
  bool reached = false;
  bool can_succeed = false;
  bool can_fail = false;
  bool redundant = true;  // every action written in this subtree is on the blackboard already
  bool lasts = false;     // an action written in this subtree can be the tick's last
  bool is_final = false;  // the tick ends after this node, whatever its status
  Outcome on_success;     // after this node; an action that is redundant counts as nothing written
  Outcome on_failure;
};

// One entry per node, in prefix order. REQUIRES: check_tree(tree, vocabulary).
std::vector<NodeFlow> flow_of(const Tree& tree, const Vocabulary& vocabulary, Facts facts);

}  // namespace coppice
