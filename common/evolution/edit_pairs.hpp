// Edits of two conditions at one place of a tree. A working part of edit_ranking.hpp.
#pragma once

#include <cstddef>

#include "common/evolution/edit_candidate.hpp"
#include "common/evolution/edit_shortlist.hpp"
#include "common/evolution/edit_sums.hpp"

namespace coppice {

struct PairForms {
  bool branch = false;  // (sequence c d a) and (sequence (selector c d) a): it may fail
  bool list = false;    // (selector (sequence c a) (sequence d b) e): it never does
};

struct PairPlace {
  EditCandidate place;            // where; nodes: what goes, if anything
  double base = 0.0;              // what the tree gains as it is
  std::ptrdiff_t conditions = 0;  // what goes of them
  PairForms forms;
};

// Offers all pairs of conditions of different features, at the place that `sums` has taken up.
void rank_pairs(EditSums& sums, const PairPlace& at, std::size_t actions, EditShortlist& shortlist);

}  // namespace coppice
