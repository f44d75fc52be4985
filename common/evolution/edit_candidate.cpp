#include "common/evolution/edit_candidate.hpp"

#include <tuple>
#include <utility>
#include <vector>

#include "common/evolution/tree_draft.hpp"

namespace coppice {
namespace {

TreeDraft composite_of(NodeKind kind, std::vector<TreeDraft> children) {
  return {Node::composite(kind, 1), std::move(children)};
}

TreeDraft action_leaf(std::uint8_t action) { return {Node::action(ActionId{action})}; }

// (sequence condition action)
TreeDraft branch_of(const Node& condition, std::uint8_t action) {
  return composite_of(NodeKind::sequence, {{condition}, action_leaf(action)});
}

// What is put at the place. there: what stands there now.
TreeDraft part_of(const EditCandidate& candidate, const TreeDraft& there) {
  TreeDraft condition{candidate.condition};
  const TreeDraft second{candidate.second_condition};
  switch (candidate.form) {
    case EditForm::action:
      return action_leaf(candidate.action);
    case EditForm::condition:
      return condition;
    case EditForm::branch:
      return branch_of(candidate.condition, candidate.action);
    case EditForm::unless:
      return composite_of(NodeKind::selector, {condition, action_leaf(candidate.action)});
    case EditForm::choice:
      return composite_of(NodeKind::selector,
                          {branch_of(candidate.condition, candidate.action), action_leaf(candidate.second)});
    case EditForm::guard:
      return composite_of(NodeKind::sequence, {condition, there});
    case EditForm::precede:
      return composite_of(NodeKind::selector, {branch_of(candidate.condition, candidate.action), there});
    case EditForm::both:
      return composite_of(NodeKind::sequence, {condition, second, action_leaf(candidate.action)});
    case EditForm::either:
      return composite_of(NodeKind::sequence,
                          {composite_of(NodeKind::selector, {condition, second}), action_leaf(candidate.action)});
    case EditForm::list:
      return composite_of(NodeKind::selector,
                          {branch_of(candidate.condition, candidate.action),
                           branch_of(candidate.second_condition, candidate.second), action_leaf(candidate.third)});
    case EditForm::remove:
    case EditForm::swap:
      break;
  }
  return there;
}

}  // namespace

bool EditCandidate::operator<(const EditCandidate& worse) const {
  return std::tie(worse.gain, nodes, order) < std::tie(gain, worse.nodes, worse.order);
}

std::optional<Tree> edited(const Tree& tree, const EditCandidate& candidate) {
  TreeDraft root = TreeDraft::of(tree.nodes());
  const TreeDraft::Place place = root.places()[candidate.node];
  TreeDraft& draft = *place.draft;
  if (candidate.form == EditForm::remove) {
    place.parent->remove(place.index());
  } else if (candidate.form == EditForm::swap) {
    std::swap(draft.children[candidate.gap], draft.children[candidate.other]);
  } else if (candidate.gap != kNowhere) {
    draft.insert(candidate.gap, part_of(candidate, draft));
  } else {
    draft = part_of(candidate, draft);
  }
  root.tidy();
  return root.finished();
}

}  // namespace coppice
