// The opposite of a test, written with the conditions that a vocabulary has: trees know no "not". Pure functions.
#pragma once

#include <optional>
#include <vector>

#include "common/tree/node.hpp"
#include "common/tree/vocabulary.hpp"

namespace coppice {

// Holds where `test` does not, for every observation that the vocabulary allows: composites change places, a condition
// becomes the other values of its feature (s3=0: (selector s3=1 s3=3)). Nothing where the feature's operators cannot
// say so, or where it would exceed kMaxTreeNodes. REQUIRES: `test` is a well-formed subtree without actions, in prefix
// order, of that vocabulary.
std::optional<std::vector<Node>> negation(const std::vector<Node>& test, const Vocabulary& vocabulary);

// A test that always holds, the shortest there is: the last value of a feature with <=, or all values of one.
std::vector<Node> always_true(const Vocabulary& vocabulary);

}  // namespace coppice
