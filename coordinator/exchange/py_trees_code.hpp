// A tree as a Python file for py_trees (2.x): create_root() builds it from Sequence and Selector without memory,
// conditions that read the blackboard and actions that write to it; action(observation) ticks it once.
#pragma once

#include <string>

#include "coordinator/exchange/exported_tree.hpp"

namespace coppice {

std::string to_py_trees_code(const ExportedTree& exported);

}  // namespace coppice
