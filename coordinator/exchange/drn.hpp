// Storm's explicit format DRN, in: Markov decision processes and discrete-time chains with rewards.
//
//   @type: MDP, @parameters, @reward_models, @nr_states, @nr_choices, @model; then for each state
//   `state 0 [reward of the state, one per model] labels`, a line `//[x=0 & !picked]` with its valuation (Storm writes
//   it with --build-state-valuations; states without one are sinks that Storm added), `action NAME [reward of the
//   choice]`, `17 : 0.625`.
//
// A reward is the state's and the choice's together. A label `init` marks the start; with several, all are alike.
// States without a valuation read what a state that leads to them reads. Without any valuation there is one feature,
// `state`. Refused by name: continuous time, partial observability, parameters, intervals, placeholders.
#pragma once

#include <string>

#include "common/error.hpp"
#include "coordinator/exchange/model.hpp"

namespace coppice {

// `reward`: a reward model, or several with signs ("gain - cost"); empty: the only one, or gain - cost where these two
// are the models (as Coppice exports signed rewards). Errors name file and line, what was found and what was expected.
Result<Model> read_drn(const std::string& path, const std::string& reward);

}  // namespace coppice
