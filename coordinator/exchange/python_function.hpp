// A tree as a Python file with one function: action(observation), from a mapping of feature names to values, each in
// its own unit, to the action's name, or None. Python 3, no imports.
#pragma once

#include <string>

#include "coordinator/exchange/exported_tree.hpp"

namespace coppice {

// REQUIRES: is_guarded(exported.tree).
std::string to_python_function(const ExportedTree& exported);

}  // namespace coppice
