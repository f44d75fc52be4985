// Writes a model as Storm's DRN (`storm --explicit-drn FILE`, stormpy.build_model_from_drn): an MDP, the Markov chain
// under a tree, or either with intervals (Storm 1.12 and later). A state's features stand in a comment line before its
// choices, as Storm writes state valuations itself: `//[s0=0 & s1=1]`, bins by their number. Reward models: gain, cost.
#pragma once

#include <ostream>

#include "coordinator/exchange/markov_model.hpp"

namespace coppice {

void write_drn(const MarkovModel& model, bool intervals, std::ostream& out);

}  // namespace coppice
