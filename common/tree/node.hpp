// One node of a behaviour tree, and the limits that hold for every tree, trusted or not.
#pragma once

#include <cstddef>
#include <cstdint>

#include "common/tree/vocabulary.hpp"

namespace coppice {

enum class NodeKind : std::uint8_t {
  sequence = 0,   // succeeds when all children succeed; stops at the first that fails
  selector = 1,   // succeeds at the first child that succeeds; fails when all fail
  condition = 2,  // succeeds when feature `index` <op> `value` holds
  action = 3,     // writes action `index` to the blackboard and succeeds
};

inline constexpr std::size_t kMaxTreeNodes = 4096;
inline constexpr std::size_t kMaxTreeDepth = 64;  // in edges from the root

struct Node {
  NodeKind kind = NodeKind::action;
  Op op = Op::equal;         // conditions only, else Op::equal
  std::uint8_t index = 0;    // condition: feature; action: action; composite: 0
  std::uint8_t value = 0;    // conditions only, else 0
  std::uint16_t extent = 1;  // nodes in this subtree, itself included

  bool is_composite() const { return kind == NodeKind::sequence || kind == NodeKind::selector; }
  bool is_leaf() const { return !is_composite(); }
  ActionId action() const { return ActionId{index}; }
  bool operator==(const Node&) const = default;

  static Node condition(std::size_t feature, Op op, std::uint8_t value) {
    return {NodeKind::condition, op, static_cast<std::uint8_t>(feature), value, 1};
  }
  static Node action(ActionId action) { return {NodeKind::action, Op::equal, static_cast<std::uint8_t>(action), 0, 1}; }
  static Node composite(NodeKind kind, std::size_t extent) {
    return {kind, Op::equal, 0, 0, static_cast<std::uint16_t>(extent)};
  }
};

}  // namespace coppice
