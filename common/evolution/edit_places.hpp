// A tree taken apart on some states of a chain: for every place in it, what the tick would select if the place failed,
// succeeded, or wrote an action and succeeded, the rest of the tick being what it is. A working part of
// edit_ranking.hpp. Refers to its tree and chain.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/evolution/edit_candidate.hpp"
#include "common/tree/tree.hpp"

namespace coppice {

class EditPlaces {
 public:
  // states: in which the tree is ticked; `m` below is an index into them.
  EditPlaces(const Chain& chain, const Tree& tree, std::span<const std::uint32_t> states);

  // What a place makes of a state: the action that the tick selects if the place fails, or succeeds without writing;
  // and whether what it writes is overwritten. The number of actions stands for none.
  struct Outcome {
    bool reached = false;
    std::uint8_t on_failure = 0;
    std::uint8_t on_success = 0;
    bool overwritten = false;
  };
  Outcome at_node(std::size_t node, std::size_t m) const;
  // Before child `gap` of `parent`, or behind the last.
  Outcome at_gap(std::size_t parent, std::size_t gap, std::size_t m) const;
  // What is selected when children a < b of `parent` have changed places.
  std::uint8_t swapped(std::size_t parent, std::size_t a, std::size_t b, std::size_t m) const;

  // What the tree selects.
  std::uint8_t now(std::size_t m) const { return now_[m]; }
  // [children], node numbers
  const std::vector<std::size_t>& children(std::size_t node) const { return children_[node]; }
  // kNowhere: of the root.
  std::size_t parent(std::size_t node) const { return parent_[node]; }
  bool is_selector(std::size_t node) const { return tree_[node].kind == NodeKind::selector; }

 private:
  // What a tick of a node, or of some siblings in turn, gives in one state.
  struct Ticked {
    std::uint8_t succeeds = 0;
    std::uint8_t writes = 0;  // an action, or kNothing
  };
  static Ticked then(bool selector, Ticked first, Ticked rest);
  std::size_t at(std::size_t node, std::size_t m) const { return node * states_.size() + m; }
  void execute();
  void continue_everywhere();
  std::uint8_t after(std::size_t parent, Ticked rest, std::size_t m) const;

  const Chain& chain_;
  const Tree& tree_;
  std::span<const std::uint32_t> states_;
  std::vector<std::vector<std::size_t>> children_;
  std::vector<std::size_t> parent_;
  // Arrays are [nodes x states], a node's states together.
  std::vector<Ticked> ticked_;
  std::vector<Ticked> after_;      // of the siblings behind
  std::vector<std::uint8_t> now_;  // [states]
  std::vector<std::uint8_t> reached_;
  std::vector<std::uint8_t> board_;
  std::vector<std::uint8_t> end_reached_;  // behind the last child
  std::vector<std::uint8_t> end_board_;
  std::vector<std::uint8_t> succeeded_;  // what is written later if the node succeeds
  std::vector<std::uint8_t> failed_;
};

}  // namespace coppice
