// Breeding::edit(): the small changes that a local search makes.
#include <algorithm>
#include <span>
#include <vector>

#include "common/evolution/breeding.hpp"
#include "common/evolution/flat_draft.hpp"
#include "common/tree/simplify.hpp"

namespace coppice {
namespace {

constexpr int kMaxAttempts = 8;         // at a changed tree within the limits
constexpr int kMaxChanges = 4;          // in one edit
constexpr double kAnotherChange = 0.3;  // probability, after each
constexpr double kCondition = 0.7;      // probability that a new leaf is one

NodeKind other(NodeKind kind) { return kind == NodeKind::sequence ? NodeKind::selector : NodeKind::sequence; }

// The order in which it draws is part of every result's identity.
class Edit {
 public:
  Edit(Stream& stream, const Vocabulary& vocabulary, FlatDraft& draft)
      : stream_(stream),
        vocabulary_(vocabulary),
        below_([&stream](std::uint64_t n) { return stream.below(n); }),
        draft_(draft) {}

  void change() {
    const std::size_t place = stream_.below(draft_.size());
    // Chances in 20ths; what cannot be done at the place is left.
    const std::uint64_t chosen = stream_.below(20);
    if (chosen < 5) {
      alter(place);
    } else if (chosen < 9) {
      put_in(place, leaf());
    } else if (chosen < 13) {
      if (place > 0) {
        draft_.remove(place);
      }
    } else if (chosen < 15) {
      put_in(place, branch());
    } else if (chosen < 17) {
      swap_children(place);
    } else if (chosen < 19) {
      move(place);
    } else {
      wrap(place, leaf());
    }
  }

 private:
  using Part = std::span<const Node>;  // in part_

  // Draws until the leaf is of the wanted kind: half of all are.
  Node leaf_of(NodeKind kind) {
    while (true) {
      const Node node = random_leaf(vocabulary_, below_);
      if (node.kind == kind) {
        return node;
      }
    }
  }

  Part leaf() {
    part_.assign(1, leaf_of(stream_.chance(kCondition) ? NodeKind::condition : NodeKind::action));
    return part_;
  }

  Part branch() {
    const std::uint64_t conditions = 1 + stream_.below(2);
    part_.assign(1, Node::composite(NodeKind::sequence, conditions + 2));
    for (std::uint64_t i = 0; i < conditions; ++i) {
      part_.push_back(leaf_of(NodeKind::condition));
    }
    part_.push_back(leaf_of(NodeKind::action));
    return part_;
  }

  void alter(std::size_t place) {
    Node node = draft_[place];
    if (node.is_composite()) {
      node.kind = other(node.kind);
    } else {
      constexpr double kOtherKind = 0.1;
      node = stream_.chance(kOtherKind) ? random_leaf(vocabulary_, below_) : mutated_leaf(node, vocabulary_, below_);
    }
    draft_.replace(place, node);
  }

  void put_in(std::size_t place, Part part) {
    if (draft_[place].is_composite()) {
      draft_.insert(place, stream_.below(draft_.children(place) + 1), part);
    } else {
      wrap(place, part);
    }
  }

  void wrap(std::size_t place, Part sibling) {
    NodeKind kind = stream_.below(2) == 0 ? NodeKind::sequence : NodeKind::selector;
    if (draft_[place].is_composite()) {
      kind = other(draft_[place].kind);
    }
    draft_.wrap(place, kind, sibling, stream_.below(2) == 0);
  }

  void swap_children(std::size_t place) {
    const std::size_t children = draft_.children(place);
    if (children > 1) {
      const std::size_t a = stream_.below(children);
      const std::size_t b = stream_.below(children);
      if (a != b) {
        draft_.swap_children(place, std::min(a, b), std::max(a, b));
      }
    }
  }

  void move(std::size_t place) {
    if (place == 0) {
      return;
    }
    const Part moved = draft_.subtree(place);
    part_.assign(moved.begin(), moved.end());
    draft_.remove(place);
    put_in(stream_.below(draft_.size()), part_);
  }

  Stream& stream_;
  const Vocabulary& vocabulary_;
  Below below_;
  FlatDraft& draft_;
  std::vector<Node> part_;
};

}  // namespace

Tree Breeding::simplified(const Tree& tree) const {
  Tree smaller = simplify(tree, vocabulary_).tree;
  return within_limits(smaller) ? smaller : tree;
}

Tree Breeding::edit(Stream& stream, const Tree& tree) const {
  FlatDraft draft(tree.nodes());
  Edit edit(stream, vocabulary_, draft);
  for (int attempt = 0; attempt < kMaxAttempts; ++attempt) {
    draft.assign(tree.nodes());
    edit.change();
    for (int change = 1; change < kMaxChanges && stream.chance(kAnotherChange); ++change) {
      edit.change();
    }
    draft.tidy();
    if (draft.size() > shape_.max_nodes || std::ranges::equal(draft.nodes(), tree.nodes())) {
      continue;  // most of those that fail do so here, before there is a tree
    }
    if (auto changed = draft.finished(); changed && within_limits(*changed)) {
      return std::move(*changed);
    }
  }
  return tree;
}

}  // namespace coppice
