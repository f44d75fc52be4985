// How a vocabulary is written in BehaviorTree.CPP's XML: the same names for writing and for reading back. A value; any
// thread may read it.
//
// With scripts a feature is an entry of the blackboard, `s3==0`; the action's number goes to the entry `action`. With
// registered nodes every condition and every action is a node of its own, without ports, that the robot registers:
// `s3_is_0`, `pole_angle_at_most_0p0419` (p: the point, m: minus), `turn_left`.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "common/tree/node.hpp"
#include "common/tree/vocabulary.hpp"

namespace coppice {

inline constexpr const char* kActionEntry = "action";

// [features] Identifiers of scripts; a name that scripts keep for themselves gets a '_' behind it.
std::vector<std::string> entry_names(const Vocabulary& vocabulary);

struct NodeIds {
  std::vector<std::string> actions;        // [actions]; a name of one of the library's own nodes gets a '_' behind it
  std::map<std::string, Node> conditions;  // every condition that the vocabulary admits
};

// Error (bad_input): two conditions, or a condition and an action, would have one ID.
Result<NodeIds> node_ids(const Vocabulary& vocabulary);

std::string condition_id(const Node& condition, const Vocabulary& vocabulary);

}  // namespace coppice
