// check_tree() for many trees of one vocabulary: every child that is bred and every tree that comes over the wire is
// checked, so it must cost next to nothing. Immutable; safe from any thread.
#pragma once

#include <cstdint>
#include <vector>

#include "common/error.hpp"
#include "common/tree/tree.hpp"

namespace coppice {

class TreeChecker {
 public:
  // The vocabulary must outlive it.
  explicit TreeChecker(const Vocabulary& vocabulary);

  // What check_tree(tree, vocabulary) returns.
  Result<void> check(const Tree& tree) const;
  bool admits(const Tree& tree) const;

 private:
  const Vocabulary& vocabulary_;
  std::vector<std::uint64_t> conditions_;  // a bit for every operator, feature index and value that a node can hold
};

}  // namespace coppice
