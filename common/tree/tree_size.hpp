// How large a tree is for somebody who reads it: nodes, of which so many ask and so many act. A binary decision tree of
// n tests is a tree of n conditions, whatever composites hold them together. Pure functions.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

#include "common/tree/node.hpp"

namespace coppice {

inline std::size_t condition_count(std::span<const Node> nodes) {
  return static_cast<std::size_t>(
      std::count_if(nodes.begin(), nodes.end(), [](const Node& node) { return node.kind == NodeKind::condition; }));
}

inline std::size_t action_count(std::span<const Node> nodes) {
  return static_cast<std::size_t>(
      std::count_if(nodes.begin(), nodes.end(), [](const Node& node) { return node.kind == NodeKind::action; }));
}

}  // namespace coppice
