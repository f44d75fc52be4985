// A tree as XML of BehaviorTree.CPP 4, for Groot2 and for stock executors.
//
// `scripts` runs in the library with nothing registered: conditions are ScriptCondition nodes on entries of the root
// blackboard, actions are Script nodes that write the action's number to the entry `action`. The host sets `action` to
// -1 and every feature before a tick, ticks once, and reads `action`: what our tick gives, guarded or not, for Sequence
// and Fallback begin at their first child at every tick when nothing ever runs, and the last write stays.
//
// `nodes` names what the robot registers itself: a condition node for every condition, an action node for every action,
// without ports, and a TreeNodesModel that declares them. Such actions act at once, so only guarded trees are written.
#pragma once

#include <string>

#include "coordinator/exchange/exported_tree.hpp"

namespace coppice {

enum class BehaviorTreeStyle : std::uint8_t { scripts, nodes };

// Errors (bad_input): names that collide (behavior_tree_names.hpp); with scripts a feature is tested for a number that
// lies within 1.2e-7 of another of its numbers, which the library's == cannot tell apart. REQUIRES: with `nodes`
// is_guarded(exported.tree).
Result<std::string> to_behavior_tree_xml(const ExportedTree& exported, BehaviorTreeStyle style);

}  // namespace coppice
