// PRISM's explicit files, in: `model.tra` and, beside it where they are there, `model.sta`, `model.lab`, `model.srew`
// and `model.trew`.
//
//   .tra   MDP: `states choices transitions`, then `state choice successor probability [action]`; chain: `states
//          transitions`, then `state successor probability`
//   .sta   `(x,y)`, then `0:(1,true)`: what is read in each state; without it there is one feature, `state`
//   .lab   `0="init" 1="deadlock"`, then `0: 0 1`: `init` marks where episodes start, all such states alike; without it
//          state 0 does
//   .srew  `states entries`, then `state reward`; .trew as .tra with rewards in place of probabilities: the state's
//   reward
//          and the transition's count together, the latter by its probability. `model.gain.srew` counts as well, and
//          `model.cost.srew` against it; .trew likewise
//
// A choice without an action's name is called by its number in the state ("choice0").
#pragma once

#include <string>

#include "common/error.hpp"
#include "coordinator/exchange/model.hpp"

namespace coppice {

// `path`: the .tra file. Errors name file and line, what was found and what was expected.
Result<Model> read_prism(const std::string& path);

}  // namespace coppice
