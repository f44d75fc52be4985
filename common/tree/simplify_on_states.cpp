// simplify() against a chain's states: greedy removal, each step checked by the whole action table.
#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <iterator>

#include "common/check.hpp"
#include "common/tree/action_table.hpp"
#include "common/tree/simplify.hpp"
#include "common/tree/text.hpp"

namespace coppice {
namespace {

// Put `keep`, a child of composite `node`, in its place; or take `node` away altogether.
struct Edit {
  std::size_t gain = 0;  // nodes fewer
  std::size_t node = 0;
  std::size_t keep = 0;  // 0: take away
};

// Largest gain first, then first in the tree.
bool comes_first(const Edit& a, const Edit& b) {
  if (a.gain != b.gain) {
    return a.gain > b.gain;
  }
  return a.node != b.node ? a.node < b.node : a.keep < b.keep;
}

// Every edit that leaves a well-formed tree, best first. With two children, to hoist one is to take away the other.
std::vector<Edit> edits_of(const Tree& tree) {
  std::vector<Edit> edits;
  for (std::size_t i = 0; i < tree.size(); ++i) {
    const std::size_t children = child_count(tree.subtree(i));
    for (std::size_t child = i + 1; children > 0 && child < i + tree[i].extent; child += tree[child].extent) {
      if (children > 1) {
        edits.push_back({tree[child].extent, child, 0});
      }
      if (children != 2) {
        edits.push_back({std::size_t{tree[i].extent} - tree[child].extent, i, child});
      }
    }
  }
  std::sort(edits.begin(), edits.end(), comes_first);
  return edits;
}

Tree edited(const Tree& tree, const Edit& edit) {
  return tree.with_subtree(edit.node, edit.keep == 0 ? std::span<const Node>() : tree.subtree(edit.keep));
}

// In which states a node is reached, succeeds and fails, summed up over all states.
struct Seen {
  bool reached = false;
  bool succeeds = false;
  bool fails = false;
};

class Observation {
 public:
  Observation(const Tree& tree, const StateColumns& columns) : tree_(tree), columns_(columns), seen_(tree.size()) {
    for (std::size_t word = 0; word < columns.words(); ++word) {
      run(0, columns.all()[word], word);
    }
  }

  const Seen& of(std::size_t i) const { return seen_[i]; }

 private:
  // The states of `active` in which node i succeeds; one word of states.
  std::uint64_t run(std::size_t i, std::uint64_t active, std::size_t word) {
    const Node& node = tree_[i];
    std::uint64_t succeeded = active;
    if (node.kind == NodeKind::condition) {
      succeeded = active & columns_.column(node)[word];
    } else if (node.is_composite()) {
      const bool is_sequence = node.kind == NodeKind::sequence;
      std::uint64_t onward = active;
      for (std::size_t child = i + 1; child < i + node.extent && onward != 0; child += tree_[child].extent) {
        const std::uint64_t done = run(child, onward, word);
        onward = is_sequence ? done : onward & ~done;
      }
      succeeded = is_sequence ? onward : active & ~onward;
    }
    seen_[i].reached |= active != 0;
    seen_[i].succeeds |= succeeded != 0;
    seen_[i].fails |= (active & ~succeeded) != 0;
    return succeeded;
  }

  const Tree& tree_;
  const StateColumns& columns_;
  std::vector<Seen> seen_;
};

Tree alone(const Tree& tree, std::size_t i) {
  const std::span<const Node> nodes = tree.subtree(i);
  Result<Tree> subtree = Tree::from_nodes({nodes.begin(), nodes.end()});
  COPPICE_CHECK(subtree.has_value());
  return *std::move(subtree);
}

class StatePruning {
 public:
  StatePruning(const Tree& tree, const Vocabulary& vocabulary, const StateColumns& columns)
      : vocabulary_(vocabulary), columns_(columns), wanted_(columns.states()), table_(columns.states()) {
    fill_action_table(tree, columns_, kNone, wanted_);
  }

  // Tries every edit once, best first; an edit that is made gives the later ones a smaller tree. True when one was.
  bool sweep(Simplified& result) {
    bool changed = false;
    std::vector<Edit> edits = edits_of(result.tree);
    for (std::size_t next = 0; next < edits.size();) {
      const Edit edit = edits[next];
      Tree candidate = edited(result.tree, edit);
      if (!means_the_same(candidate)) {
        ++next;
        continue;
      }
      result.removals.push_back(removal(result.tree, edit));
      result.tree = std::move(candidate);
      changed = true;
      edits = edits_of(result.tree);
      next = static_cast<std::size_t>(
          std::distance(edits.begin(), std::lower_bound(edits.begin(), edits.end(), edit, comes_first)));
    }
    return changed;
  }

 private:
  static constexpr auto kNone = static_cast<std::uint8_t>(kNoAction);

  bool means_the_same(const Tree& candidate) {
    fill_action_table(candidate, columns_, kNone, table_);
    return table_ == wanted_;
  }

  Removal removal(const Tree& tree, const Edit& edit) const {
    return {to_text(alone(tree, edit.node), vocabulary_), reason(tree, edit), edit.gain};
  }

  std::string reason(const Tree& tree, const Edit& edit) const {
    if (edit.keep != 0) {
      return fmt::format("in all {} states its child {} gives the same actions alone", columns_.states(),
                         to_text(alone(tree, edit.keep), vocabulary_));
    }
    const Seen seen = Observation(tree, columns_).of(edit.node);
    const bool is_condition = tree[edit.node].kind == NodeKind::condition;
    if (!seen.reached) {
      return fmt::format("never reached in any of the {} states", columns_.states());
    }
    if (is_condition && seen.succeeds != seen.fails) {
      return fmt::format("always {} in those of the {} states that reach it", seen.succeeds ? "true" : "false",
                         columns_.states());
    }
    return fmt::format("all {} states keep their action without it", columns_.states());
  }

  const Vocabulary& vocabulary_;
  const StateColumns& columns_;
  std::vector<std::uint8_t> wanted_;
  std::vector<std::uint8_t> table_;
};

}  // namespace

Simplified simplify(const Tree& tree, const Vocabulary& vocabulary, const StateColumns& columns) {
  StatePruning pruning(tree, vocabulary, columns);
  Simplified result = simplify(tree, vocabulary);
  // A sweep that changes anything leaves fewer nodes.
  for (std::size_t round = 0; round < kMaxTreeNodes && pruning.sweep(result); ++round) {
    Simplified sound = simplify(result.tree, vocabulary);
    result.tree = std::move(sound.tree);
    std::move(sound.removals.begin(), sound.removals.end(), std::back_inserter(result.removals));
  }
  return result;
}

}  // namespace coppice
