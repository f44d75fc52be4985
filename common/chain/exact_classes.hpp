// Where a walk ends up: the closed classes of the states that it can reach (sets that it never leaves again, in which
// every state leads to every other), by Tarjan's algorithm (1972), without recursion.
#pragma once

#include <cstdint>
#include <vector>

#include "common/chain/exact_rows.hpp"

namespace coppice {

inline constexpr std::uint32_t kTransient = 0xFFFFFFFF;

// For every number of `rows` the lowest number of its closed class, kTransient if it is in none. [rows.size()]
// REQUIRES: rows.expand_all().
std::vector<std::uint32_t> closed_classes(const ReachedRows& rows);

}  // namespace coppice
