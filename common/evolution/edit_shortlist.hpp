// The best edits of one tree so far, and what becomes of it by them. A working part of edit_ranking.hpp.
#pragma once

#include <cstddef>
#include <vector>

#include "common/evolution/edit_candidate.hpp"
#include "common/evolution/edit_ranking.hpp"
#include "common/tree/tree.hpp"

namespace coppice {

class EditShortlist {
 public:
  // Refers to the tree. count: how many will be asked for.
  EditShortlist(const Tree& tree, const EditLimits& limits, std::size_t count);

  // Takes it in if it is within the limits and among the best so far. conditions: more than the tree has now.
  void offer(EditCandidate candidate, std::ptrdiff_t conditions);

  // The `count` best as trees, the best first, each once.
  std::vector<RankedEdit> made(std::size_t count);

 private:
  bool fits(const Tree& tree) const;

  const Tree& tree_;
  EditLimits limits_;
  std::size_t kept_;
  std::size_t conditions_;  // of the tree
  std::size_t order_ = 0;
  std::vector<EditCandidate> candidates_;  // a heap, the worst first
};

}  // namespace coppice
