#include "coordinator/exchange/guarded_code.hpp"

#include <algorithm>
#include <vector>

#include "common/check.hpp"
#include "common/tree/guard.hpp"

namespace coppice {
namespace {

class Code {
 public:
  Code(const Tree& tree, const CodeSyntax& syntax) : tree_(tree), syntax_(syntax) {}

  std::string take() && { return std::move(text_); }

  void line(int level, const std::string& text) {
    for (int i = 0; i < level; ++i) {
      text_ += syntax_.indent;
    }
    text_ += text + '\n';
  }

  // Statements that return where the subtree acts, or succeeds without acting, and fall through where it fails. False:
  // they always return, so that nothing behind them is reached.
  bool falls_through(std::size_t i, int level) {
    const Node& node = tree_[i];
    if (node.kind == NodeKind::action) {
      line(level, syntax_.result(node.action()));
      return false;
    }
    if (only_asks(i)) {
      block(test(i, NodeKind::action), level, [&](int inside) { line(inside, syntax_.result(kNoAction)); });
      return true;
    }
    const std::vector<std::size_t> children = children_of(i);
    if (node.kind == NodeKind::selector) {
      return std::all_of(children.begin(), children.end(),
                         [&](std::size_t child) { return falls_through(child, level); });
    }
    std::string tests;
    for (std::size_t c = 0; c + 1 < children.size(); ++c) {
      tests +=
          (c == 0 ? "" : syntax_.all) + test(children[c], children.size() > 2 ? NodeKind::sequence : NodeKind::action);
    }
    if (tests.empty()) {
      return falls_through(children.back(), level);
    }
    block(tests, level, [&](int inside) { falls_through(children.back(), inside); });
    return true;
  }

 private:
  template <typename Body>
  void block(const std::string& tests, int level, const Body& body) {
    line(level, syntax_.open_if(tests));
    body(level + 1);
    if (!syntax_.close_if.empty()) {
      line(level, syntax_.close_if);
    }
  }

  std::vector<std::size_t> children_of(std::size_t i) const {
    std::vector<std::size_t> children;
    for (std::size_t child = i + 1; child < i + tree_[i].extent; child += tree_[child].extent) {
      children.push_back(child);
    }
    return children;
  }

  bool only_asks(std::size_t i) const {
    const auto nodes = tree_.subtree(i);
    return std::none_of(nodes.begin(), nodes.end(), [](const Node& n) { return n.kind == NodeKind::action; });
  }

  // `around`: the composite that the test stands in; another kind inside it gets parentheses. NodeKind::action: none.
  std::string test(std::size_t i, NodeKind around) const {
    const Node& node = tree_[i];
    if (node.is_leaf()) {
      return syntax_.condition(node);
    }
    const std::vector<std::size_t> children = children_of(i);
    if (children.size() == 1) {
      return test(children.front(), around);
    }
    std::string text;
    for (const std::size_t child : children) {
      text += (text.empty()                      ? ""
               : node.kind == NodeKind::sequence ? syntax_.all
                                                 : syntax_.any) +
              test(child, node.kind);
    }
    return around == NodeKind::action || around == node.kind ? text : '(' + text + ')';
  }

  const Tree& tree_;
  const CodeSyntax& syntax_;
  std::string text_;
};

}  // namespace

std::string guarded_code(const Tree& tree, const CodeSyntax& syntax, int level) {
  COPPICE_CHECK(is_guarded(tree));
  Code code(tree, syntax);
  if (code.falls_through(0, level)) {
    code.line(level, syntax.result(kNoAction));
  }
  return std::move(code).take();
}

}  // namespace coppice
