// A tree as one C++17 header without dependencies: a struct of readings, an enum of actions, and a constexpr function
// from one to the other that allocates nothing and throws nothing.
#pragma once

#include <string>

#include "coordinator/exchange/exported_tree.hpp"

namespace coppice {

// REQUIRES: is_guarded(exported.tree). Names that are words of C++ get a '_' behind them.
std::string to_cpp_header(const ExportedTree& exported);

}  // namespace coppice
