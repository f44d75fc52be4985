// One small change of a tree, before it is made: where, what, and what it gains. The working parts of edit_ranking.hpp;
// nobody else needs them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "common/tree/tree.hpp"

namespace coppice {

enum class EditForm : std::uint8_t {
  action,     // a
  condition,  // c
  branch,     // (sequence c a)
  unless,     // (selector c a)
  choice,     // (selector (sequence c b) a)
  guard,      // (sequence c what-is-there)
  precede,    // (selector (sequence c a) what-is-there)
  both,       // (sequence c d a)
  either,     // (sequence (selector c d) a)
  list,       // (selector (sequence c a) (sequence d b) e)
  remove,
  swap,  // two children of the node
};

inline constexpr std::size_t kNowhere = SIZE_MAX;

struct EditCandidate {
  double gain = 0.0;
  std::ptrdiff_t nodes = 0;  // more than now, before a composite with one child dissolves
  std::size_t order = 0;     // of the places, for ties
  EditForm form = EditForm::action;
  std::size_t node = 0;        // replaced, or the parent of a gap
  std::size_t gap = kNowhere;  // before this child; swap: the first child
  std::size_t other = 0;       // swap: the second child
  Node condition = {};
  Node second_condition = {};  // d
  std::uint8_t action = 0;
  std::uint8_t second = 0;  // choice: what is done where the condition does not hold; list: b
  std::uint8_t third = 0;   // list: e

  // The better one comes first.
  bool operator<(const EditCandidate& worse) const;
};

// `tree` so changed. None: beyond the limits of every tree.
std::optional<Tree> edited(const Tree& tree, const EditCandidate& candidate);

}  // namespace coppice
