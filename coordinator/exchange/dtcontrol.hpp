// The learned policy as CSV of dtControl, which makes decision trees of controllers: two header lines, then a line a
// state, its features (of bins the number) and the number of the action. Where a state ends episodes nothing is
// decided: it is left out.
#pragma once

#include <ostream>

#include "common/chain/chain.hpp"

namespace coppice {

void write_dtcontrol(const Chain& chain, std::ostream& out);

}  // namespace coppice
