// Breeding::edit(): the small changes that a local search makes.
#include <array>

#include "common/evolution/breeding.hpp"
#include "common/evolution/tree_draft.hpp"
#include "common/tree/simplify.hpp"

namespace coppice {
namespace {

constexpr int kMaxAttempts = 8;         // at a changed tree within the limits
constexpr int kMaxChanges = 4;          // in one edit
constexpr double kAnotherChange = 0.3;  // probability, after each
constexpr double kCondition = 0.7;      // probability that a new leaf is one

NodeKind other(NodeKind kind) { return kind == NodeKind::sequence ? NodeKind::selector : NodeKind::sequence; }

class Edit {
 public:
  Edit(Stream& stream, const Vocabulary& vocabulary)
      : stream_(stream), vocabulary_(vocabulary), below_([&stream](std::uint64_t n) { return stream.below(n); }) {}

  void change(TreeDraft& root) {
    const std::vector<TreeDraft::Place> places = root.places();
    const TreeDraft::Place place = places[stream_.below(places.size())];
    // Chances in 20ths; what cannot be done at the place is left.
    const std::uint64_t chosen = stream_.below(20);
    if (chosen < 5) {
      alter(*place.draft);
    } else if (chosen < 9) {
      put_in(*place.draft, leaf());
    } else if (chosen < 13) {
      take_out(place);
    } else if (chosen < 15) {
      put_in(*place.draft, branch());
    } else if (chosen < 17) {
      swap_children(*place.draft);
    } else if (chosen < 19) {
      move(root, place);
    } else {
      wrap(*place.draft, leaf());
    }
  }

 private:
  // Draws until the leaf is of the wanted kind: half of all are.
  TreeDraft leaf_of(NodeKind kind) {
    while (true) {
      const Node node = random_leaf(vocabulary_, below_);
      if (node.kind == kind) {
        return {node};
      }
    }
  }

  TreeDraft leaf() { return leaf_of(stream_.chance(kCondition) ? NodeKind::condition : NodeKind::action); }

  TreeDraft branch() {
    TreeDraft sequence{Node::composite(NodeKind::sequence, 1)};
    const std::uint64_t conditions = 1 + stream_.below(2);
    for (std::uint64_t i = 0; i < conditions; ++i) {
      sequence.children.push_back(leaf_of(NodeKind::condition));
    }
    sequence.children.push_back(leaf_of(NodeKind::action));
    return sequence;
  }

  void alter(TreeDraft& draft) {
    if (draft.node.is_composite()) {
      draft.node.kind = other(draft.node.kind);
    } else {
      constexpr double kOtherKind = 0.1;
      draft.node =
          stream_.chance(kOtherKind) ? random_leaf(vocabulary_, below_) : mutated_leaf(draft.node, vocabulary_, below_);
    }
  }

  void put_in(TreeDraft& draft, TreeDraft child) {
    if (draft.node.is_composite()) {
      draft.insert(stream_.below(draft.children.size() + 1), std::move(child));
    } else {
      wrap(draft, std::move(child));
    }
  }

  void wrap(TreeDraft& draft, TreeDraft sibling) {
    NodeKind kind = stream_.below(2) == 0 ? NodeKind::sequence : NodeKind::selector;
    if (draft.node.is_composite()) {
      kind = other(draft.node.kind);
    }
    TreeDraft composite{Node::composite(kind, 1)};
    composite.children.push_back(std::move(draft));
    composite.insert(stream_.below(2), std::move(sibling));
    draft = std::move(composite);
  }

  static void take_out(const TreeDraft::Place& place) {
    if (place.parent != nullptr) {
      place.parent->remove(place.index());
    }
  }

  void swap_children(TreeDraft& draft) {
    if (draft.children.size() > 1) {
      const std::size_t a = stream_.below(draft.children.size());
      const std::size_t b = stream_.below(draft.children.size());
      if (a != b) {
        std::swap(draft.children[a], draft.children[b]);
      }
    }
  }

  void move(TreeDraft& root, const TreeDraft::Place& place) {
    if (place.parent == nullptr) {
      return;
    }
    TreeDraft moved = std::move(*place.draft);
    take_out(place);
    const std::vector<TreeDraft::Place> places = root.places();
    put_in(*places[stream_.below(places.size())].draft, std::move(moved));
  }

  Stream& stream_;
  const Vocabulary& vocabulary_;
  Below below_;
};

}  // namespace

Tree Breeding::simplified(const Tree& tree) const {
  Tree smaller = simplify(tree, vocabulary_).tree;
  return within_limits(smaller) ? smaller : tree;
}

Tree Breeding::edit(Stream& stream, const Tree& tree) const {
  Edit edit(stream, vocabulary_);
  for (int attempt = 0; attempt < kMaxAttempts; ++attempt) {
    TreeDraft draft = TreeDraft::of(tree.nodes());
    edit.change(draft);
    for (int change = 1; change < kMaxChanges && stream.chance(kAnotherChange); ++change) {
      edit.change(draft);
    }
    draft.tidy();
    auto changed = draft.finished();
    if (changed && *changed != tree && within_limits(*changed)) {
      return std::move(*changed);
    }
  }
  return tree;
}

}  // namespace coppice
