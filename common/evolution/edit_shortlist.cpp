#include "common/evolution/edit_shortlist.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "common/tree/tree_size.hpp"

namespace coppice {
namespace {

constexpr std::size_t kSpareCandidates = 4;  // kept for each that is asked for: some spell the same tree

}  // namespace

EditShortlist::EditShortlist(const Tree& tree, const EditLimits& limits, std::size_t count)
    : tree_(tree), limits_(limits), kept_(count * kSpareCandidates), conditions_(condition_count(tree.nodes())) {}

void EditShortlist::offer(EditCandidate candidate, std::ptrdiff_t conditions) {
  if (static_cast<std::ptrdiff_t>(tree_.size()) + candidate.nodes > static_cast<std::ptrdiff_t>(limits_.max_nodes) ||
      static_cast<std::ptrdiff_t>(conditions_) + conditions > static_cast<std::ptrdiff_t>(limits_.max_conditions)) {
    return;
  }
  candidate.order = order_++;
  if (candidates_.size() == kept_) {
    if (!(candidate < candidates_.front())) {
      return;
    }
    std::pop_heap(candidates_.begin(), candidates_.end());
    candidates_.pop_back();
  }
  candidates_.push_back(candidate);
  std::push_heap(candidates_.begin(), candidates_.end());
}

std::vector<RankedEdit> EditShortlist::made(std::size_t count) {
  std::sort(candidates_.begin(), candidates_.end());
  std::vector<RankedEdit> result;
  for (const EditCandidate& candidate : candidates_) {
    if (result.size() == count) {
      break;
    }
    std::optional<Tree> tree = edited(tree_, candidate);
    if (tree && fits(*tree) &&
        std::none_of(result.begin(), result.end(), [&](const RankedEdit& better) { return better.tree == *tree; })) {
      result.push_back({candidate.gain, std::move(*tree)});
    }
  }
  return result;
}

bool EditShortlist::fits(const Tree& tree) const {
  return tree.size() <= limits_.max_nodes && condition_count(tree.nodes()) <= limits_.max_conditions && tree != tree_;
}

}  // namespace coppice
