// A guarded tree as nested ifs, the same for every language: each action becomes a return, and where a branch fails the
// program falls through to what stands behind it, as a selector does. What a language looks like comes in as functions.
#pragma once

#include <functional>
#include <string>

#include "common/tree/tree.hpp"

namespace coppice {

struct CodeSyntax {
  std::string all;                                         // between tests that must all hold: " && "
  std::string any;                                         // " || "
  std::string indent;                                      // one level
  std::function<std::string(const Node&)> condition;       // "o.s3 == 0"
  std::function<std::string(const std::string&)> open_if;  // "if (o.s3 == 0) {"
  std::string close_if;                                    // "}"; empty: nothing closes a block
  std::function<std::string(ActionId)> result;             // "return Action::move;"; kNoAction: no action
};

// Lines, each with a line end, at `level` levels of indentation; every way through them returns. REQUIRES:
// is_guarded(tree).
std::string guarded_code(const Tree& tree, const CodeSyntax& syntax, int level);

}  // namespace coppice
