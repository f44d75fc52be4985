#include "common/tree/tree_checker.hpp"

namespace coppice {
namespace {

constexpr unsigned kBits = 64;
constexpr std::size_t kOps = 2;

std::size_t place_of(Op op, std::size_t feature, std::size_t value) {
  return static_cast<std::size_t>(op) << 16U | feature << 8U | value;
}

}  // namespace

TreeChecker::TreeChecker(const Vocabulary& vocabulary)
    : vocabulary_(vocabulary), conditions_((kOps << 16U) / kBits, 0) {
  for (std::size_t f = 0; f < vocabulary.features.size(); ++f) {
    for (const Op op : {Op::equal, Op::less_equal}) {
      for (const std::uint8_t value : vocabulary.features[f].values) {
        if (vocabulary.features[f].admits(op)) {
          const std::size_t place = place_of(op, f, value);
          conditions_[place / kBits] |= std::uint64_t{1} << place % kBits;
        }
      }
    }
  }
}

// Without a branch on what the nodes are, which nobody can foretell.
bool TreeChecker::admits(const Tree& tree) const {
  const std::size_t actions = vocabulary_.actions.size();
  unsigned wrong = 0;
  for (const Node& node : tree.nodes()) {
    const std::size_t place = place_of(node.op, node.index, node.value);
    const auto known = static_cast<unsigned>(conditions_[place / kBits] >> place % kBits & 1U);
    const auto is_condition = static_cast<unsigned>(node.kind == NodeKind::condition);
    const auto is_action = static_cast<unsigned>(node.kind == NodeKind::action);
    wrong |= (is_condition & (known ^ 1U)) | (is_action & static_cast<unsigned>(node.index >= actions));
  }
  return wrong == 0;
}

Result<void> TreeChecker::check(const Tree& tree) const {
  return admits(tree) ? Result<void>{} : check_tree(tree, vocabulary_);
}

}  // namespace coppice
