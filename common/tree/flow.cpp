#include "common/tree/flow.hpp"

#include <array>
#include <optional>

namespace coppice {
namespace {

constexpr std::size_t kValues = 256;
using ValueSet = std::bitset<kValues>;
using Blackboard = std::bitset<kMaxActions + 1>;  // the last bit: nothing was written
constexpr std::size_t kNothing = kMaxActions;

// What holds at one point of a tick, over all observations that come there: a product of value sets, which may admit
// more observations than really come, never fewer.
struct Knowledge {
  bool possible = false;
  std::vector<ValueSet> values;  // [tested features]
  Blackboard blackboard;

  void join(const Knowledge& other) {
    if (!other.possible) {
      return;
    }
    if (!possible) {
      *this = other;
      return;
    }
    for (std::size_t f = 0; f < values.size(); ++f) {
      values[f] |= other.values[f];
    }
    blackboard |= other.blackboard;
  }
};

ValueSet satisfying(const Node& condition) {
  ValueSet set;
  for (std::size_t value = condition.op == Op::equal ? condition.value : 0; value <= condition.value; ++value) {
    set.set(value);
  }
  return set;
}

class Analysis {
 public:
  Analysis(const Tree& tree, const Vocabulary& vocabulary, Facts facts)
      : nodes_(tree.nodes()), facts_(facts), flow_(tree.size()) {
    Knowledge start;
    start.possible = true;
    start.blackboard.set(kNothing);
    if (facts == Facts::used) {
      name_tested_features(vocabulary, start);
    }
    forwards(0, std::move(start));
    const After end{false, {}, true};
    backwards(0, end, end);
  }

  std::vector<NodeFlow> take() { return std::move(flow_); }

 private:
  struct Exits {
    Knowledge success;
    Knowledge failure;
  };

  // The rest of a tick from some point on.
  struct After {
    bool writes = false;  // an action is surely written
    Outcome outcome;
    bool is_end = false;
  };

  void name_tested_features(const Vocabulary& vocabulary, Knowledge& start) {
    for (const Node& node : nodes_) {
      if (node.kind != NodeKind::condition || place_of_[node.index]) {
        continue;
      }
      place_of_[node.index] = start.values.size();
      ValueSet& declared = start.values.emplace_back();
      for (const std::uint8_t value : vocabulary.features[node.index].values) {
        declared.set(value);
      }
    }
  }

  Exits forwards(std::size_t i, Knowledge in) {
    if (!in.possible) {
      return {};
    }
    const Node& node = nodes_[i];
    flow_[i].reached = true;
    Exits exits;
    switch (node.kind) {
      case NodeKind::condition:
        exits = decide(node, std::move(in));
        break;
      case NodeKind::action:
        flow_[i].redundant = in.blackboard.count() == 1 && in.blackboard.test(node.index);
        in.blackboard.reset().set(node.index);
        exits.success = std::move(in);
        break;
      case NodeKind::sequence:
      case NodeKind::selector:
        exits = pass_through(i, std::move(in));
        break;
    }
    flow_[i].can_succeed = exits.success.possible;
    flow_[i].can_fail = exits.failure.possible;
    return exits;
  }

  Exits decide(const Node& condition, Knowledge in) const {
    Exits exits{in, std::move(in)};
    if (facts_ == Facts::used) {
      const std::size_t place = *place_of_[condition.index];
      const ValueSet satisfied = satisfying(condition);
      exits.success.values[place] &= satisfied;
      exits.success.possible = exits.success.values[place].any();
      exits.failure.values[place] &= ~satisfied;
      exits.failure.possible = exits.failure.values[place].any();
    }
    return exits;
  }

  Exits pass_through(std::size_t i, Knowledge in) {
    const bool is_sequence = nodes_[i].kind == NodeKind::sequence;
    Knowledge onward = std::move(in);
    Knowledge stopped;
    for (std::size_t child = i + 1; child < i + nodes_[i].extent; child += nodes_[child].extent) {
      Exits exits = forwards(child, std::move(onward));
      stopped.join(is_sequence ? exits.failure : exits.success);
      onward = std::move(is_sequence ? exits.success : exits.failure);
      flow_[i].redundant = flow_[i].redundant && flow_[child].redundant;
    }
    return is_sequence ? Exits{std::move(onward), std::move(stopped)} : Exits{std::move(stopped), std::move(onward)};
  }

  // Gives the rest of a tick from just before node i.
  After backwards(std::size_t i, const After& success, const After& failure) {
    NodeFlow& flow = flow_[i];
    flow.is_final = success.is_end && failure.is_end;
    flow.on_success = success.outcome;
    flow.on_failure = failure.outcome;
    const Node& node = nodes_[i];
    if (node.kind == NodeKind::condition) {
      return {(!flow.can_succeed || success.writes) && (!flow.can_fail || failure.writes),
              success.outcome == failure.outcome ? success.outcome : Outcome{Outcome::Kind::differs}, false};
    }
    if (node.kind == NodeKind::action) {
      flow.lasts = flow.reached && !success.writes;
      const bool last = success.outcome.kind == Outcome::Kind::nothing && !flow.redundant;
      return {true, last ? Outcome{Outcome::Kind::action, node.action()} : success.outcome, false};
    }
    std::vector<std::size_t> children;
    for (std::size_t child = i + 1; child < i + node.extent; child += nodes_[child].extent) {
      children.push_back(child);
    }
    const bool is_sequence = node.kind == NodeKind::sequence;
    After onward = is_sequence ? success : failure;
    for (auto child = children.rbegin(); child != children.rend(); ++child) {
      onward = is_sequence ? backwards(*child, onward, failure) : backwards(*child, success, onward);
      flow_[i].lasts = flow_[i].lasts || flow_[*child].lasts;
    }
    return onward;
  }

  std::span<const Node> nodes_;
  Facts facts_;
  std::array<std::optional<std::size_t>, kMaxFeatures> place_of_;  // of a tested feature in Knowledge::values
  std::vector<NodeFlow> flow_;
};

}  // namespace

std::vector<NodeFlow> flow_of(const Tree& tree, const Vocabulary& vocabulary, Facts facts) {
  return Analysis(tree, vocabulary, facts).take();
}

}  // namespace coppice
