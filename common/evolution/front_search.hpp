// Evolution towards a front of trees instead of one: NSGA-II (Deb and others 2002; dominance.hpp) with the
// random-weight selection and local search of MOGLS (Ishibuchi and Murata, "A multi-objective genetic local search
// algorithm and its application to flowshop scheduling", IEEE Transactions on Systems, Man, and Cybernetics C 28(3),
// 1998).
//
//   parents    half by rank and crowding (NSGA-II), half by a sum of the costs under weights drawn for each child
//              (MOGLS)
//
//   children   crossover and mutation, or, a share of them, edits of good trees: of the front in the last part
//
//   climbs     a share of the children go on by guided edits, as far as these lead (guided_climb.hpp): half of them
//              first towards weights drawn for them, then all towards the first of the objectives; the first generation
//              has what a beam of such climbs found, and halfway and at the end the best goes on by leaps
//
//   no two     individuals of a generation mean the same on the chain, unless the later one is smaller
//
//   next       the best of parents and children by rank and crowding
//
//   restarts   the generations are parts of equal length that begin anew, each from trees of its own; the last one
//              begins with what all have kept, so that no early luck decides the run
//
//   archive    every tree of at most front.max_nodes nodes that no other dominates, thinned where it is crowded
//
// We differ from NSGA-II: with five measures nearly all individuals are of rank 0, so rank alone selects little; the
// random weights keep the pressure (compared in README.md).
#pragma once

#include <memory>

#include "common/evolution/deme_search.hpp"

namespace coppice {

// As DemeSearch::make(), which calls it. REQUIRES: config.ga.search is front.
Result<std::unique_ptr<DemeSearch>> make_front_search(const Chain& chain, const EvolveConfig& config);

}  // namespace coppice
