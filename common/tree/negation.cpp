#include "common/tree/negation.hpp"

#include <algorithm>

namespace coppice {
namespace {

void close_subtree(std::vector<Node>& nodes, std::size_t root) {
  nodes[root].extent = static_cast<std::uint16_t>(nodes.size() - root);
}

// Conditions that together hold for exactly these values of feature f, as a selector if it takes several. `wanted` is
// parallel to the feature's values. False where they cannot be written.
bool append_values(std::size_t f, const Feature& feature, const std::vector<bool>& wanted, std::vector<Node>& out) {
  std::vector<Node> conditions;
  std::size_t next = 0;
  if (feature.admits_less_equal) {
    while (next < wanted.size() && wanted[next]) {
      ++next;
    }
    if (next > 1 || (next == 1 && !feature.admits_equal)) {
      conditions.push_back(Node::condition(f, Op::less_equal, feature.values[next - 1]));
    } else {
      next = 0;
    }
  }
  for (; next < wanted.size(); ++next) {
    if (wanted[next]) {
      if (!feature.admits_equal) {
        return false;
      }
      conditions.push_back(Node::condition(f, Op::equal, feature.values[next]));
    }
  }
  if (conditions.empty() || out.size() + conditions.size() + 1 > kMaxTreeNodes) {
    return false;
  }
  const std::size_t root = out.size();
  if (conditions.size() > 1) {
    out.push_back(Node::composite(NodeKind::selector, 0));
  }
  out.insert(out.end(), conditions.begin(), conditions.end());
  close_subtree(out, root);
  return true;
}

// As deep as the test: kMaxTreeDepth.
bool append_negation(const std::vector<Node>& test, std::size_t i, const Vocabulary& vocabulary,
                     std::vector<Node>& out) {
  const Node& node = test[i];
  if (node.kind == NodeKind::condition) {
    const Feature& feature = vocabulary.features[node.index];
    std::vector<bool> wanted;
    wanted.reserve(feature.values.size());
    for (const std::uint8_t value : feature.values) {
      wanted.push_back(node.op == Op::equal ? value != node.value : value > node.value);
    }
    return append_values(node.index, feature, wanted, out);
  }
  const std::size_t root = out.size();
  const NodeKind kind = node.kind == NodeKind::sequence ? NodeKind::selector : NodeKind::sequence;
  out.push_back(Node::composite(kind, 0));
  for (std::size_t child = i + 1; child < i + node.extent; child += test[child].extent) {
    const std::size_t at = out.size();
    if (!append_negation(test, child, vocabulary, out)) {
      return false;
    }
    if (out[at].kind == kind) {
      out.erase(out.begin() + static_cast<std::ptrdiff_t>(at));
    }
  }
  close_subtree(out, root);
  return true;
}

}  // namespace

std::optional<std::vector<Node>> negation(const std::vector<Node>& test, const Vocabulary& vocabulary) {
  std::vector<Node> result;
  if (!append_negation(test, 0, vocabulary, result)) {
    return std::nullopt;
  }
  return result;
}

std::vector<Node> always_true(const Vocabulary& vocabulary) {
  std::vector<Node> best;
  for (std::size_t f = 0; f < vocabulary.features.size(); ++f) {
    const Feature& feature = vocabulary.features[f];
    std::vector<Node> all;
    if (append_values(f, feature, std::vector<bool>(feature.values.size(), true), all) &&
        (best.empty() || all.size() < best.size())) {
      best = std::move(all);
    }
  }
  return best;  // every feature admits an operator, and either can name all values
}

}  // namespace coppice
