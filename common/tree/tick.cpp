#include "common/tree/tick.hpp"

#include "common/check.hpp"

namespace coppice {
namespace {

struct Tick {
  std::span<const Node> nodes;
  std::span<const std::uint8_t> features;
  ActionId blackboard = kNoAction;

  bool holds(const Node& condition) const {
    COPPICE_CHECK(condition.index < features.size());
    const std::uint8_t read = features[condition.index];
    return condition.op == Op::equal ? read == condition.value : read <= condition.value;
  }

  // The status of node i; writes to the blackboard on the way.
  bool succeeds(std::size_t i) {
    const Node& node = nodes[i];
    switch (node.kind) {
      case NodeKind::condition:
        return holds(node);
      case NodeKind::action:
        blackboard = node.action();
        return true;
      case NodeKind::sequence:
        for (std::size_t child = i + 1; child < i + node.extent; child += nodes[child].extent) {
          if (!succeeds(child)) {
            return false;
          }
        }
        return true;
      case NodeKind::selector:
        for (std::size_t child = i + 1; child < i + node.extent; child += nodes[child].extent) {
          if (succeeds(child)) {
            return true;
          }
        }
        return false;
    }
    COPPICE_CHECK(false);
    return false;
  }
};

}  // namespace

ActionId tick(const Tree& tree, std::span<const std::uint8_t> features) {
  Tick run{tree.nodes(), features};
  run.succeeds(0);
  return run.blackboard;
}

}  // namespace coppice
