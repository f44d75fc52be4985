// Reads XML of BehaviorTree.CPP 4 that says what our trees can say: Sequence and Fallback (also Reactive), conditions
// and actions as scripts or as registered nodes (behavior_tree_names.hpp), SubTree. Whatever has no counterpart is
// refused by name: a decorator, a node that keeps memory, pre- and postconditions, a script that says more. Trusts
// nothing.
#pragma once

#include <string>
#include <string_view>

#include "common/error.hpp"
#include "common/tree/tree.hpp"

namespace coppice {

inline constexpr std::size_t kMaxBehaviorTreeXml = std::size_t{8} << 20U;  // characters

// `name` is how messages call the input. Errors (bad_input) name the line, what was found and what was expected.
// Whatever is returned passes check_tree() for the vocabulary. Never throws on any input.
Result<Tree> parse_behavior_tree_xml(std::string_view xml, const std::string& name, const Vocabulary& vocabulary);

}  // namespace coppice
