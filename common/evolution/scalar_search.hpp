// The search of the thesis (Algorithm 1, III-D, VI-E.3): one number decides who has children. Fitness is sampled anew
// in every generation, with the same random numbers for all its individuals.
#pragma once

#include <memory>

#include "common/evolution/deme_search.hpp"

namespace coppice {

// As DemeSearch::make(), which calls it. REQUIRES: config.ga.search is scalar.
Result<std::unique_ptr<DemeSearch>> make_scalar_search(const Chain& chain, const EvolveConfig& config);

}  // namespace coppice
