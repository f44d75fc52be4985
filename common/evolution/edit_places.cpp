#include "common/evolution/edit_places.hpp"

#include <algorithm>

#include "common/tree/condition.hpp"

namespace coppice {
namespace {

constexpr std::uint8_t kNothing = 0xFF;  // no action is written

}  // namespace

EditPlaces::EditPlaces(const Chain& chain, const Tree& tree, std::span<const std::uint32_t> states)
    : chain_(chain), tree_(tree), states_(states), children_(tree.size()), parent_(tree.size(), kNowhere) {
  for (std::size_t i = 0; i < tree.size(); ++i) {
    for (std::size_t c = i + 1; c < i + tree[i].extent; c += tree[c].extent) {
      children_[i].push_back(c);
      parent_[c] = i;
    }
  }
  execute();
  continue_everywhere();
}

// `first`, then what comes after it under a parent of this kind.
EditPlaces::Ticked EditPlaces::then(bool selector, Ticked first, Ticked rest) {
  if ((first.succeeds != 0) == selector) {
    return first;
  }
  return {rest.succeeds, rest.writes != kNothing ? rest.writes : first.writes};
}

// Backwards: what each node ticks to. Children come after their parents.
void EditPlaces::execute() {
  const std::size_t size = tree_.size() * states_.size();
  ticked_.resize(size);
  after_.resize(size);
  for (std::size_t i = tree_.size(); i-- > 0;) {
    const Node& node = tree_[i];
    Ticked* const ticked = ticked_.data() + at(i, 0);
    if (node.kind == NodeKind::condition) {
      for (std::size_t m = 0; m < states_.size(); ++m) {
        ticked[m] = {static_cast<std::uint8_t>(holds(node, chain_.features_of(states_[m]))), kNothing};
      }
    } else if (node.kind == NodeKind::action) {
      std::fill_n(ticked, states_.size(), Ticked{1, node.index});
    } else {
      std::fill_n(ticked, states_.size(), Ticked{static_cast<std::uint8_t>(!is_selector(i)), kNothing});
      for (auto child = children_[i].rbegin(); child != children_[i].rend(); ++child) {
        const Ticked* const first = ticked_.data() + at(*child, 0);
        Ticked* const after = after_.data() + at(*child, 0);
        for (std::size_t m = 0; m < states_.size(); ++m) {
          after[m] = ticked[m];
          ticked[m] = then(is_selector(i), first[m], ticked[m]);
        }
      }
    }
  }
  now_.resize(states_.size());
  for (std::size_t m = 0; m < states_.size(); ++m) {
    const std::uint8_t written = ticked_[at(0, m)].writes;
    now_[m] = written != kNothing ? written : static_cast<std::uint8_t>(chain_.actions());
  }
}

// Forwards: where a node is reached, with what on the blackboard; and what the tick writes after it.
void EditPlaces::continue_everywhere() {
  const std::size_t size = tree_.size() * states_.size();
  reached_.assign(size, 1);
  board_.assign(size, static_cast<std::uint8_t>(chain_.actions()));
  end_reached_.assign(size, 0);
  end_board_.assign(size, 0);
  succeeded_.assign(size, kNothing);
  failed_.assign(size, kNothing);
  for (std::size_t i = 0; i < tree_.size(); ++i) {
    if (!tree_[i].is_composite()) {
      continue;
    }
    const bool selector = is_selector(i);
    std::uint8_t* const reached = end_reached_.data() + at(i, 0);
    std::uint8_t* const board = end_board_.data() + at(i, 0);
    std::copy_n(reached_.begin() + static_cast<std::ptrdiff_t>(at(i, 0)), states_.size(), reached);
    std::copy_n(board_.begin() + static_cast<std::ptrdiff_t>(at(i, 0)), states_.size(), board);
    for (const std::size_t child : children_[i]) {
      const std::size_t begin = at(child, 0);
      std::copy_n(reached, states_.size(), reached_.begin() + static_cast<std::ptrdiff_t>(begin));
      std::copy_n(board, states_.size(), board_.begin() + static_cast<std::ptrdiff_t>(begin));
      for (std::size_t m = 0; m < states_.size(); ++m) {
        const std::uint8_t later = after(i, after_[begin + m], m);
        succeeded_[begin + m] = selector ? succeeded_[at(i, m)] : later;
        failed_[begin + m] = selector ? later : failed_[at(i, m)];
        const Ticked ticked = ticked_[begin + m];
        reached[m] &= static_cast<std::uint8_t>((ticked.succeeds != 0) != selector);
        board[m] = ticked.writes != kNothing ? ticked.writes : board[m];
      }
    }
  }
}

// What is written by the rest of a composite's children, which ticks so, and by all that follows.
std::uint8_t EditPlaces::after(std::size_t parent, Ticked rest, std::size_t m) const {
  const std::uint8_t next = rest.succeeds != 0 ? succeeded_[at(parent, m)] : failed_[at(parent, m)];
  return next != kNothing ? next : rest.writes;
}

EditPlaces::Outcome EditPlaces::at_node(std::size_t node, std::size_t m) const {
  const std::size_t here = at(node, m);
  const auto written = [&](std::uint8_t later) { return later != kNothing ? later : board_[here]; };
  return {reached_[here] != 0, written(failed_[here]), written(succeeded_[here]), succeeded_[here] != kNothing};
}

EditPlaces::Outcome EditPlaces::at_gap(std::size_t parent, std::size_t gap, std::size_t m) const {
  const bool at_end = gap == children_[parent].size();
  const std::size_t here = at_end ? kNowhere : at(children_[parent][gap], m);
  const bool reached = (at_end ? end_reached_[at(parent, m)] : reached_[here]) != 0;
  const std::uint8_t board = at_end ? end_board_[at(parent, m)] : board_[here];
  const std::uint8_t success = succeeded_[at(parent, m)];
  const std::uint8_t failure = failed_[at(parent, m)];
  if (is_selector(parent)) {
    return {reached, now_[m], success != kNothing ? success : board, success != kNothing};
  }
  const Ticked rest = at_end ? Ticked{1, kNothing} : then(false, ticked_[here], after_[here]);
  return {reached, failure != kNothing ? failure : board, now_[m], after(parent, rest, m) != kNothing};
}

// From what each of the children ticks to.
std::uint8_t EditPlaces::swapped(std::size_t parent, std::size_t a, std::size_t b, std::size_t m) const {
  const std::vector<std::size_t>& children = children_[parent];
  const std::size_t here = at(children[a], m);
  if (reached_[here] == 0) {
    return now_[m];
  }
  const bool selector = is_selector(parent);
  Ticked rest = then(selector, ticked_[here], after_[at(children[b], m)]);
  for (std::size_t k = b; k-- > a + 1;) {
    rest = then(selector, ticked_[at(children[k], m)], rest);
  }
  rest = then(selector, ticked_[at(children[b], m)], rest);
  const std::uint8_t later = after(parent, rest, m);
  return later != kNothing ? later : board_[here];
}

}  // namespace coppice
