#include "common/evolution/flat_draft.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <vector>

#include "common/chain/random.hpp"
#include "common/evolution/tree_draft.hpp"
#include "common/tree/random_tree.hpp"
#include "common/tree/text.hpp"
#include "tests/coordinator/evolution/small_world.hpp"

namespace coppice {
namespace {

const Vocabulary kDraftVocabulary = testing::small_vocabulary();

std::vector<Node> nodes_of(const TreeDraft& draft) {
  std::vector<Node> nodes = {draft.node};
  for (const TreeDraft& child : draft.children) {
    const std::vector<Node> below = nodes_of(child);
    nodes.insert(nodes.end(), below.begin(), below.end());
  }
  nodes.front().extent = static_cast<std::uint16_t>(nodes.size());
  return nodes;
}

// The same random changes to a flat draft and to one whose nodes own their children.
class TwoDrafts {
 public:
  TwoDrafts(Stream& stream, const Tree& tree)
      : stream_(stream), flat_(tree.nodes()), owning_(TreeDraft::of(tree.nodes())) {}

  void change() {
    const std::size_t place = stream_.below(flat_.size());
    const TreeDraft::Place same = owning_.places()[place];
    const Tree part = grow_tree(kDraftVocabulary, {2, 3}, false, [&](std::uint64_t n) { return stream_.below(n); });
    switch (stream_.below(5)) {
      case 0:
        if (flat_[place].is_composite()) {
          const std::size_t child = stream_.below(flat_.children(place) + 1);
          flat_.insert(place, child, part.nodes());
          same.draft->insert(child, TreeDraft::of(part.nodes()));
        }
        break;
      case 1:
        if (place > 0) {
          flat_.remove(place);
          same.parent->remove(same.index());
        }
        break;
      case 2: {
        const bool first = stream_.below(2) == 0;
        flat_.wrap(place, NodeKind::selector, part.nodes(), first);
        TreeDraft around{Node::composite(NodeKind::selector, 1)};
        around.children.push_back(std::move(*same.draft));
        around.insert(first ? 0 : 1, TreeDraft::of(part.nodes()));
        *same.draft = std::move(around);
        break;
      }
      case 3:
        if (const std::size_t children = flat_.children(place); children > 1) {
          const std::size_t b = 1 + stream_.below(children - 1);
          const std::size_t a = stream_.below(b);
          flat_.swap_children(place, a, b);
          std::swap(same.draft->children[a], same.draft->children[b]);
        }
        break;
      default:
        if (flat_[place].is_composite()) {
          flat_.replace(place, Node::composite(NodeKind::sequence, 1));
          same.draft->node.kind = NodeKind::sequence;
        }
    }
  }

  void tidy() {
    flat_.tidy();
    owning_.tidy();
  }

  const FlatDraft& flat() const { return flat_; }
  const TreeDraft& owning() const { return owning_; }

 private:
  Stream& stream_;
  FlatDraft flat_;
  TreeDraft owning_;
};

TEST(FlatDraft, ChangesAsOneWhoseNodesOwnTheirChildren) {
  Stream stream(3, Purpose::simulating, 0, 0);
  for (int round = 0; round < 2000; ++round) {
    TwoDrafts drafts(stream,
                     grow_tree(kDraftVocabulary, {4, 4}, true, [&](std::uint64_t n) { return stream.below(n); }));
    for (std::uint64_t change = stream.below(6); change > 0; --change) {
      drafts.change();
      ASSERT_TRUE(std::ranges::equal(drafts.flat().nodes(), nodes_of(drafts.owning()))) << "round " << round;
    }
    drafts.tidy();
    ASSERT_TRUE(std::ranges::equal(drafts.flat().nodes(), nodes_of(drafts.owning()))) << "round " << round;
    ASSERT_EQ(drafts.flat().finished(), drafts.owning().finished());
  }
}

TEST(FlatDraft, DissolvesWhatHasOneChildOrIsOfItsParentsKind) {
  FlatDraft draft(
      testing::tree_of("(selector (selector a=1 (sequence b=0 left)) (sequence (selector move left)))").nodes());
  draft.tidy();
  EXPECT_EQ(to_text(*draft.finished(), kDraftVocabulary), "(selector a=1 (sequence b=0 left) move left)");
}

TEST(FlatDraft, IsNoTreeOnceNothingIsLeft) {
  FlatDraft draft(testing::tree_of("(sequence a=1 left)").nodes());
  draft.remove(2);
  draft.remove(1);
  EXPECT_EQ(draft.size(), 1U);
  EXPECT_EQ(draft.children(0), 0U);
  draft.tidy();
  EXPECT_EQ(draft.finished(), std::nullopt);
  draft.assign(Tree(ActionId{0}).nodes());
  draft.tidy();
  EXPECT_EQ(draft.finished(), Tree(ActionId{0}));
}

}  // namespace
}  // namespace coppice
