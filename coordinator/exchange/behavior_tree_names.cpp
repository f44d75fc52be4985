#include "coordinator/exchange/behavior_tree_names.hpp"

#include <fmt/format.h>
#include <set>

#include "coordinator/exchange/exported_tree.hpp"

namespace coppice {
namespace {

// scripting/operators.hpp of BehaviorTree.CPP 4.9: words of the script language; and the entry that we write.
const std::set<std::string> script_words = {"true", "false", kActionEntry};

// The nodes that BehaviorTreeFactory registers by itself (src/bt_factory.cpp, 4.9).
const std::set<std::string> built_in_nodes = {"Action",
                                              "AlwaysFailure",
                                              "AlwaysSuccess",
                                              "AsyncFallback",
                                              "AsyncSequence",
                                              "BehaviorTree",
                                              "Condition",
                                              "Control",
                                              "Decorator",
                                              "Delay",
                                              "EntryUpdated",
                                              "Fallback",
                                              "ForceFailure",
                                              "ForceSuccess",
                                              "IfThenElse",
                                              "Inverter",
                                              "KeepRunningUntilFailure",
                                              "LoopBool",
                                              "LoopDouble",
                                              "LoopInt",
                                              "LoopString",
                                              "ManualSelector",
                                              "Parallel",
                                              "ParallelAll",
                                              "Precondition",
                                              "ReactiveFallback",
                                              "ReactiveSequence",
                                              "Repeat",
                                              "RetryUntilSuccessful",
                                              "RunOnce",
                                              "Script",
                                              "ScriptCondition",
                                              "Sequence",
                                              "SequenceStar",
                                              "SequenceWithMemory",
                                              "SetBlackboard",
                                              "SkipUnlessUpdated",
                                              "Sleep",
                                              "SubTree",
                                              "Switch2",
                                              "Switch3",
                                              "Switch4",
                                              "Switch5",
                                              "Switch6",
                                              "TestNode",
                                              "Timeout",
                                              "TreeNodesModel",
                                              "TryCatch",
                                              "UnsetBlackboard",
                                              "WaitValueUpdate",
                                              "WasEntryUpdated",
                                              "WhileDoElse",
                                              "include",
                                              "root"};

// "-0.25" as a part of a name: "m0p25"; "1e-07": "1em07".
std::string number_in_name(const std::string& number) {
  std::string name;
  for (const char c : number) {
    name += c == '-' ? 'm' : c == '.' ? 'p' : c;
  }
  std::erase(name, '+');
  return name;
}

}  // namespace

std::string condition_id(const Node& condition, const Vocabulary& vocabulary) {
  const Feature& feature = vocabulary.features[condition.index];
  return fmt::format("{}_{}_{}", feature.name, condition.op == Op::equal ? "is" : "at_most",
                     number_in_name(feature.number_text(condition.value)));
}

std::vector<std::string> entry_names(const Vocabulary& vocabulary) {
  return identifiers(feature_names(vocabulary), script_words);
}

Result<NodeIds> node_ids(const Vocabulary& vocabulary) {
  NodeIds ids;
  ids.actions = identifiers(vocabulary.actions, built_in_nodes);
  const std::set<std::string> actions(ids.actions.begin(), ids.actions.end());
  for (std::size_t f = 0; f < vocabulary.features.size(); ++f) {
    const Feature& feature = vocabulary.features[f];
    for (const Op op : {Op::equal, Op::less_equal}) {
      if (!feature.admits(op)) {
        continue;
      }
      for (const std::uint8_t value : feature.values) {
        const Node condition = Node::condition(f, op, value);
        const std::string id = condition_id(condition, vocabulary);
        if (actions.count(id) != 0 || !ids.conditions.emplace(id, condition).second) {
          return bad_input(
              fmt::format("feature '{}': a node of BehaviorTree.CPP would have the ID '{}' of another: "
                          "expected other names, or scripts instead of nodes",
                          feature.name, id));
        }
      }
    }
  }
  return ids;
}

}  // namespace coppice
