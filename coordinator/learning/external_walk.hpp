// A controller in a problem's own simulator (external_simulator.hpp): what simulate.hpp does in our worlds, with the
// same records. The tree is ticked on the readings themselves, so it runs on observations that the chain never met.
#pragma once

#include <vector>

#include "coordinator/learning/external_simulator.hpp"
#include "coordinator/learning/simulate.hpp"

namespace coppice {

// tree: nullptr for the learned policy itself. Each episode is seeded by f(seed, its number), so two controllers meet
// the same luck as far as the simulator's own randomness is a function of its seed. Where a tree does not act what
// takes place is what the chain says (Chain::taken); in a state that the chain does not know a named action, or, for
// `worst`, action 0. Errors: those of the simulator; interrupted. Nothing is kept of a run that fails. REQUIRES:
// check_tree(*tree, chain.vocabulary()).
Result<std::vector<EpisodeRecord>> simulate_outside(ExternalSimulator& simulator, const Chain& chain, const Tree* tree,
                                                    const SimulateSettings& settings, const SimulateProgress& go_on,
                                                    const SimulateWatch& watch);

}  // namespace coppice
