// What a tree decides, without the writes on the way: a graph of tests whose ends are the tick's action or none. A
// point of a tick is a leaf together with what is on the blackboard there, so the graph has at most leaves x (actions +
// 1) nodes, however many paths lead through it; equal nodes are one. guard() writes trees from it. A value; const
// members are safe from any thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <tuple>
#include <vector>

#include "common/tree/tree.hpp"
#include "common/tree/vocabulary.hpp"

namespace coppice {

class DecisionGraph {
 public:
  using Id = std::uint32_t;

  // A test and where it leads. Both ways lead to smaller ids.
  struct Decision {
    std::vector<Node> test;  // a subtree without actions, in prefix order
    Id yes = 0;
    Id no = 0;
  };

  // tick(tree) for every observation, whether the vocabulary declares its values or not. REQUIRES: check_tree(tree,
  // vocabulary).
  DecisionGraph(const Tree& tree, const Vocabulary& vocabulary);

  // Where both ways of a test lead to the same second test, and that to the same place on one side, the second test is
  // asked first and once: what was written between does not matter to it.
  void ask_shared_tests_first();

  // Tests that lead the same way are joined into one, `any` or `all` of them, where nothing else leads to the second.
  void join_tests();

  Id root() const { return root_; }
  // Ids below this one are ends: action_end(a), or none_end(), where nothing was written.
  std::size_t ends() const { return actions_ + 1; }
  Id none_end() const { return static_cast<Id>(actions_); }
  bool is_end(Id id) const { return id < ends(); }
  ActionId action_of(Id end) const { return end == none_end() ? kNoAction : ActionId{static_cast<std::uint8_t>(end)}; }
  std::size_t size() const { return ends() + decisions_.size(); }
  // REQUIRES: !is_end(id), id < size().
  const Decision& decision(Id id) const { return decisions_[id - ends()]; }
  // How many ways lead to each node; the root has one from outside.
  std::vector<std::uint32_t> ways_in() const;

 private:
  using Key = std::tuple<std::uint8_t, Op, std::uint8_t, Id, Id>;

  Decision& decision(Id id) { return decisions_[id - ends()]; }

  // The node of that decision, made where there is none yet; `yes` where both ways are one.
  Id node_of(const Node& condition, Id yes, Id no);
  // The same, the tests that both ways share asked before it.
  Id asked_first(const Node& condition, Id yes, Id no);
  // Leaves no decision that the root does not lead to.
  void drop_unreached();

  std::size_t actions_;
  std::vector<Decision> decisions_;
  std::map<Key, Id> known_;  // while every test is one condition
  Id root_ = 0;
};

// "a and b" (sequence) or "a or b" (selector) as one subtree; a part of the same kind gives its children.
std::vector<Node> joined(NodeKind kind, const std::vector<Node>& a, const std::vector<Node>& b);

}  // namespace coppice
