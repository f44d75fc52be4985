// The guarded form: a tree that asks before it acts. Our tick keeps the last action that was written, so `(sequence
// turn_left s3=0 move)` may write first and ask later; a robot that acts at once when it meets an action must not. In a
// guarded tree whatever stands in a sequence before its last child only asks. So an action, once met, is the last
// thing that the tick does: it succeeds, and with it everything around it. Pure functions.
#pragma once

#include <cstddef>

#include "common/error.hpp"
#include "common/tree/tree.hpp"

namespace coppice {

// Whether every child of a sequence but the last is free of actions. In such a tree no tick meets two actions, and none
// fails after it has met one. Removing, hoisting and dissolving nodes, as simplify() does, keep it so.
bool is_guarded(const Tree& tree);

// The most tests that guard() takes on, counted after equal ones are one. Trees of hundreds of nodes have far fewer.
inline constexpr std::size_t kMaxGuardTests = 2048;

// A guarded tree with the same action, or none, for every observation that the vocabulary allows: the smallest of the
// ways tried, simplified. `tree` itself, simplified, where that is guarded and none is smaller. Most trees become no
// larger; one that changes what it has written again and again can grow, because a tree shares nothing: such a part is
// written out once for each action that it is met with. The same tree gives the same result everywhere.
// Errors (bad_input): the result would exceed kMaxTreeNodes or kMaxTreeDepth, or the tree has more than kMaxGuardTests
// tests. REQUIRES: check_tree(tree, vocabulary).
Result<Tree> guard(const Tree& tree, const Vocabulary& vocabulary);

}  // namespace coppice
