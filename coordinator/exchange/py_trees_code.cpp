#include "coordinator/exchange/py_trees_code.hpp"

#include <fmt/format.h>

#include "common/tree/text.hpp"

namespace coppice {
namespace {

constexpr const char* kPyTreesClasses = R"("""A behaviour tree for py_trees that coppice wrote.

Features are read from the blackboard under /observation/, the action's name is written to /action. Set /action to
None before each tick: a tree may tick without acting.
"""
import operator

import py_trees
from py_trees.common import Access, Status


class Condition(py_trees.behaviour.Behaviour):
    """Succeeds where the feature's value passes the test."""

    def __init__(self, name, feature, test, value):
        super().__init__(name)
        self.key, self.test, self.value = "/observation/" + feature, test, value
        self.board = self.attach_blackboard_client()
        self.board.register_key(self.key, access=Access.READ)

    def update(self):
        return Status.SUCCESS if self.test(self.board.get(self.key), self.value) else Status.FAILURE


class Act(py_trees.behaviour.Behaviour):
    """Writes its action and succeeds. Replace it by the behaviour that acts."""

    def __init__(self, name, action):
        super().__init__(name)
        self.action = action
        self.board = self.attach_blackboard_client()
        self.board.register_key("/action", access=Access.WRITE)

    def update(self):
        self.board.set("/action", self.action)
        return Status.SUCCESS


)";

constexpr const char* kPyTreesPolicy = R"(

class Policy:
    """The tree with a blackboard client of its own."""

    def __init__(self):
        self.root = create_root()
        self.board = py_trees.blackboard.Client(name="policy")
        self.board.register_key("/action", access=Access.WRITE)
        for feature in FEATURES:
            self.board.register_key("/observation/" + feature, access=Access.WRITE)

    def action(self, observation):
        """The action's name, or None. observation: a mapping from feature names to values, each in its own unit."""
        for feature in FEATURES:
            self.board.set("/observation/" + feature, observation[feature])
        self.board.set("/action", None)
        self.root.tick_once()
        return self.board.get("/action")


_policy = None


def action(observation):
    """As Policy.action(), with one policy made at the first call."""
    global _policy
    if _policy is None:
        _policy = Policy()
    return _policy.action(observation)
)";

std::string python_text(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : one_line(text)) {
    quoted += c == '"' ? '\'' : c;
  }
  return quoted + '"';
}

std::string behaviour(const Node& node, const ExportedTree& exported) {
  const std::string words = in_words(node, exported.problem, exported.vocabulary);
  const std::string name = python_text(words.empty() ? to_text(node, exported.vocabulary) : words);
  if (node.kind == NodeKind::action) {
    return fmt::format("Act({}, \"{}\")", name, exported.vocabulary.actions[node.index]);
  }
  const Feature& feature = exported.vocabulary.features[node.index];
  return fmt::format("Condition({}, \"{}\", operator.{}, {})", name, feature.name, node.op == Op::equal ? "eq" : "le",
                     compared_number(feature, node.value));
}

}  // namespace

std::string to_py_trees_code(const ExportedTree& exported) {
  const Tree& tree = exported.tree;
  std::string text;
  for (const std::string& line : header_lines(exported)) {
    text += "# " + line + '\n';
  }
  text += kPyTreesClasses;
  std::string features;
  std::vector<bool> tested(exported.vocabulary.features.size(), false);
  for (const Node& node : tree.nodes()) {
    if (node.kind == NodeKind::condition && !tested[node.index]) {
      tested[node.index] = true;
      features += fmt::format("{}\"{}\"", features.empty() ? "" : ", ", exported.vocabulary.features[node.index].name);
    }
  }
  text += fmt::format("FEATURES = [{}]\n\n\ndef create_root():\n    \"\"\"The tree, new each time.\"\"\"\n    return ",
                      features);
  std::vector<std::size_t> ends;  // of the composites that are open
  for (std::size_t i = 0; i < tree.size(); ++i) {
    const Node& node = tree[i];
    if (i > 0) {
      text += '\n' + std::string(4 + 4 * ends.size(), ' ');
    }
    if (node.is_composite()) {
      const char* kind = node.kind == NodeKind::sequence ? "Sequence" : "Selector";
      text += fmt::format("py_trees.composites.{}(\"{}\", memory=False, children=[", kind,
                          node.kind == NodeKind::sequence ? "sequence" : "selector");
      ends.push_back(i + node.extent);
      continue;
    }
    text += behaviour(node, exported);
    while (!ends.empty() && ends.back() == i + 1) {
      ends.pop_back();
      text += "])";
    }
    text += ends.empty() ? "" : ",";
  }
  return text + '\n' + kPyTreesPolicy;
}

}  // namespace coppice
