// Changes to a tree, given as text. Nodes are numbered in prefix order from 0, the root, as numbered() shows them, and
// all changes speak of the tree as it was before any of them, so that their order does not matter.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/error.hpp"
#include "common/tree/tree.hpp"

namespace coppice {

struct TreeEdit {
  enum class Kind : std::uint8_t { replace, insert, remove };
  Kind kind = Kind::remove;
  std::size_t node = 0;      // insert: the composite that gets another child
  std::size_t position = 0;  // insert: in front of the child of this number, from 0; the number of children: behind
  std::optional<Tree> subtree{};  // replace, insert
};

// replace: "N SUBTREE"; insert: "N POSITION SUBTREE"; remove: "N". Errors say what was found and what was expected.
Result<TreeEdit> parse_edit(TreeEdit::Kind kind, std::string_view text, const Vocabulary& vocabulary);

// Errors: no such node or position; a node that is changed twice, or lies within one that goes; a composite that would
// be left without children; a tree beyond kMaxTreeNodes or kMaxTreeDepth. Insertions at one place come in their order.
Result<Tree> apply_edits(const Tree& tree, const std::vector<TreeEdit>& edits);

}  // namespace coppice
