// A file that holds one tree, in whatever form it was exported: our text, JSON, or XML of BehaviorTree.CPP 4. The form
// is told from the first character that is not blank.
#pragma once

#include <string>
#include <string_view>

#include "common/error.hpp"
#include "common/tree/tree.hpp"

namespace coppice {

enum class TreeForm : std::uint8_t { text, json, behavior_tree_xml };
TreeForm tree_form(std::string_view content);

// REQUIRES: not TreeForm::text, whose lines may hold comments and more than one tree: see the commands' tree_lines.
// Errors: as parse_tree_json() and parse_behavior_tree_xml().
Result<Tree> parse_tree_document(std::string_view content, const std::string& name, const Vocabulary& vocabulary);

}  // namespace coppice
