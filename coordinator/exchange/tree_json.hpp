// A tree as JSON, with everything that its conditions and actions mean: for programs of any language, for the Python
// package (coppice.Tree.load), and to be read back. The format:
//
//   {"format": "coppice-tree-1", "origin": "uav.coppice, run 1", "nodes": 18, "text": "(selector ...)",
//    "features": [{"name": "s3", "label": "ahead", "unit": "", "values": [0, 1, 3], "value_labels": {"0": "wall"}},
//                 {"name": "pole_angle", "bins": [-0.1, 0.0419]}],
//    "actions": [{"name": "turn_left", "label": ""}],
//    "tree": {"type": "selector", "children": [
//      {"type": "sequence", "children": [{"type": "condition", "feature": "s3", "op": "=", "value": 0, "words": "..."},
//                                        {"type": "action", "action": "turn_left"}]}, ...]}}
//
// Values are numbers of the feature's own unit; "inf" is the last bin, which has no upper edge.
#pragma once

#include <string>
#include <string_view>

#include "coordinator/exchange/exported_tree.hpp"

namespace coppice {

inline constexpr std::size_t kMaxTreeJson = std::size_t{8} << 20U;  // characters

// Two blanks a level, with a line end.
std::string to_tree_json(const ExportedTree& exported);

// Reads "tree" of such an object, or a bare node; features and actions are the vocabulary's. `name` is how messages
// call the input. Errors (bad_input) name the place in the tree ("tree.children[1].value"), what was found and what was
// expected. Whatever is returned passes check_tree() for the vocabulary. Never throws on any input.
Result<Tree> parse_tree_json(std::string_view text, const std::string& name, const Vocabulary& vocabulary);

}  // namespace coppice
