#include "common/tree/tick.hpp"

#include <algorithm>

#include "common/check.hpp"
#include "common/tree/condition.hpp"

namespace coppice {
namespace {

// Holds: whether a condition does, by what is observed.
template <typename Holds>
struct Tick {
  std::span<const Node> nodes;
  Holds holds;
  ActionId blackboard = kNoAction;

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
  const auto holds = [features](const Node& condition) {
    COPPICE_CHECK(condition.index < features.size());
    return coppice::holds(condition, features);
  };
  Tick<decltype(holds)> run{tree.nodes(), holds};
  run.succeeds(0);
  return run.blackboard;
}

ActionId tick_readings(const Tree& tree, const Vocabulary& vocabulary, std::span<const double> readings) {
  COPPICE_CHECK(readings.size() == vocabulary.features.size());
  const auto holds = [&](const Node& condition) {
    const Feature& feature = vocabulary.features[condition.index];
    double number = condition.value;
    if (feature.scale != Scale::plain) {
      const auto value = std::lower_bound(feature.values.begin(), feature.values.end(), condition.value);
      const auto place = static_cast<std::size_t>(value - feature.values.begin());
      if (place == feature.numbers.size()) {  // the last bin has no upper edge
        return true;
      }
      number = feature.numbers[place];
    }
    return condition.op == Op::equal ? readings[condition.index] == number : readings[condition.index] <= number;
  };
  Tick<decltype(holds)> run{tree.nodes(), holds};
  run.succeeds(0);
  return run.blackboard;
}

}  // namespace coppice
