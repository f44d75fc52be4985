#include "coordinator/trust/verification_report.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "common/chain/exact.hpp"
#include "common/tree/action_table.hpp"
#include "common/tree/state_columns.hpp"
#include "common/tree/text.hpp"
#include "coordinator/console/counted.hpp"
#include "coordinator/console/json_line.hpp"

namespace coppice {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kNameWidth = 46;
constexpr std::size_t kCellWidth = 32;

std::string percent(double share) {
  if (share == 0.0 || share == 1.0) {
    return share == 0.0 ? "0 %" : "100 %";
  }
  if (share < 0.001) {
    return fmt::format("{:.2g} %", 100.0 * share);
  }
  // Never rounded up to a certainty that it is not.
  return share > 0.9999 ? "> 99.99 %" : fmt::format("{:.2f} %", 100.0 * share);
}

std::string number(double value) {
  return std::abs(value) >= 1e5 ? fmt::format("{:.4g}", value) : fmt::format("{:.2f}", value);
}

template <typename Text>
std::string cell(const std::optional<Figure>& figure, const Text& text, const char* otherwise) {
  return figure ? fmt::format("{} [{}, {}]", text(figure->value), text(figure->low), text(figure->high)) : otherwise;
}

std::string row(const std::string& name, const std::string& ours, const std::string& simulator) {
  std::string line = fmt::format("  {:<{}}{:<{}}{}", name, kNameWidth, ours, kCellWidth, simulator);
  line.erase(line.find_last_not_of(' ') + 1);
  return line + '\n';
}

constexpr const char* kNotSolved = "not solved";
constexpr const char* kNever = "never";

// A walk that leaves the model for certain tells nothing about "ever": what would come after is not known.
constexpr double kMostlyLeaves = 0.05;

// `unless` goes behind "ever".
std::string event_text(const EventFigures& event, const std::string& title, std::uint32_t steps,
                       const std::string& simulator, const char* unless = "") {
  const bool solved = event.ever.has_value();
  std::string text =
      row(fmt::format("{} within {}", title, counted(steps, "step")), cell(event.within, percent, ""), simulator);
  text += row(fmt::format("{} ever{}", title, unless), cell(event.ever, percent, kNotSolved), "");
  text +=
      row("  expected steps until then, where it comes", cell(event.steps, number, solved ? kNever : kNotSolved), "");
  return text;
}

Json json_of(const std::optional<Figure>& figure) {
  return figure ? Json{{"value", figure->value}, {"low", figure->low}, {"high", figure->high}} : Json(nullptr);
}

Json json_of(const EventFigures& event) {
  return {{"name", event.name},
          {"test", event.test},
          {"pairs", event.pairs},
          {"unclear_pairs", event.unclear},
          {"within", json_of(event.within)},
          {"ever", json_of(event.ever)},
          {"steps", json_of(event.steps)}};
}

std::string action_text(const Vocabulary& vocabulary, ActionId action) {
  return action == kNoAction ? "none" : vocabulary.actions[index_of(action)];
}

std::string role_text(const NodeRole& role, const Node& node) {
  if (!role.ticked) {
    return "";
  }
  if (node.kind == NodeKind::action) {
    return role.last_word ? "has the last word" : "is overwritten";
  }
  if (node.kind == NodeKind::condition) {
    return role.succeeds && role.fails ? "goes either way" : role.succeeds ? "holds" : "fails";
  }
  return "ticked";
}

}  // namespace

Result<CheckedRule> check_on(const Rule& rule, const Tree& tree, const Chain& chain) {
  Result<RuleAnswer> answer = check_rule(rule, tree, chain.vocabulary());
  if (!answer) {
    return tl::unexpected(std::move(answer).error());
  }
  CheckedRule checked{.rule = rule, .answer = std::move(*answer), .states = 0, .seen = std::nullopt};
  const std::vector<ActionId> table = action_table(tree, StateColumns(chain.vocabulary(), chain.parts().features));
  for (std::size_t state = 0; state < chain.states(); ++state) {
    if (!rule.applies(chain.features_of(state))) {
      continue;
    }
    ++checked.states;
    if (rule.broken_by(table[state]) &&
        (!checked.seen || chain.parts().visits[state] > chain.parts().visits[*checked.seen])) {
      checked.seen = state;
    }
  }
  return checked;
}

std::string observation_text(const Vocabulary& vocabulary, std::span<const std::uint8_t> features,
                             const std::vector<bool>& shown) {
  std::string text;
  for (std::size_t f = 0; f < features.size(); ++f) {
    if (shown.empty() || shown[f]) {
      text += (text.empty() ? "" : " ") + vocabulary.features[f].reading_text(features[f]);
    }
  }
  return text.empty() ? "any" : text;
}

std::string numbered(const Tree& tree, const Vocabulary& vocabulary, const Problem& problem,
                     const std::vector<std::string>& remarks) {
  std::string text;
  const std::size_t width = std::to_string(tree.size() - 1).size();
  std::vector<std::size_t> ends;  // of the composites around the node
  for (std::size_t node = 0; node < tree.size(); ++node) {
    while (!ends.empty() && ends.back() <= node) {
      ends.pop_back();
    }
    std::string remark = in_words(tree[node], problem, vocabulary);
    if (node < remarks.size() && !remarks[node].empty()) {
      remark += (remark.empty() ? "" : "  ") + remarks[node];
    }
    const std::string shown = std::string(2 * ends.size(), ' ') + to_text(tree[node], vocabulary);
    text += remark.empty() ? fmt::format("  {:>{}}  {}\n", node, width, shown)
                           : fmt::format("  {:>{}}  {:<28}  {}\n", node, width, shown, remark);
    if (tree[node].is_composite()) {
      ends.push_back(node + tree[node].extent);
    }
  }
  return text;
}

std::string to_text(const Verification& verification, const std::optional<Simulated>& simulated) {
  const std::uint32_t steps = verification.settings.steps;
  std::string text = fmt::format(
      "Exact on the chain under the tree, {} of {} states reached. [,] is a 95 % interval for the counts: {} draws of "
      "the\n"
      "counted rows from their Dirichlet posterior (Bayesian bootstrap), each solved anew, seed {}.\n",
      verification.reached, verification.states, verification.settings.resamples, verification.settings.seed);
  if (simulated) {
    text += fmt::format("Simulator: {} of {}; 95 % intervals for the episodes.\n",
                        counted(simulated->episodes, "episode"), counted(steps, "step"));
  }
  text += row("", "on the chain", simulated ? "in the simulator" : "");
  text += row(fmt::format("reward per episode of {}", counted(steps, "step")), cell(verification.reward, number, ""),
              simulated ? cell(simulated->reward, number, "") : "");
  text += row("  the policy earns, and the gap",
              fmt::format("{:.2f} ({:+.2f})", verification.policy_reward,
                          verification.reward.value - verification.policy_reward),
              "");
  if (verification.most_reward) {
    text += row("  no policy can earn more than", fmt::format("{:.2f}", *verification.most_reward), "");
  }
  text += row("reward per step in the long run", cell(verification.reward_per_step, number, kNotSolved), "");
  const auto& leaves = verification.untried.ever;
  const bool mostly_leaves = leaves && leaves->value >= kMostlyLeaves;
  for (const EventFigures& event : verification.events) {
    text += event_text(event, event.name, steps,
                       simulated && event.name == "collision" ? cell(simulated->collision, percent, "") : "",
                       mostly_leaves ? ", before it leaves the model" : "");
  }
  text += event_text(verification.untried, "leaves the model", steps, "");
  text += row(fmt::format("  or by a successor never seen, {}", counted(steps, "step")),
              cell(verification.unseen.within, percent, ""), simulated ? cell(simulated->unknown, percent, "") : "");
  for (const EventFigures& event : verification.events) {
    text += fmt::format("{}: an action whose recorded mean has {}: {} of state and action", event.name, event.test,
                        counted(event.pairs, "pair"));
    text += event.unclear > 0 ? fmt::format("; in {} the recorded reward is a mix and does not tell\n",
                                            counted(event.unclear, "pair"))
                              : "\n";
  }
  text +=
      "leaves the model: takes an action that learning never tried in that state. Events count before that: add its\n"
      "probability for an upper bound. Successors never seen: estimated from those seen once (Good 1953).\n";
  if (verification.intervals_too_narrow()) {
    text += fmt::format(
        "The intervals are too narrow: {} of the episodes come to an action or a successor that learning never saw, "
        "and no\n"
        "draw of the counts knows what follows. Learn longer.\n",
        percent(verification.unseen.within.value));
  }
  if (mostly_leaves) {
    text += fmt::format(
        "\"ever\" says little here: {} of the walks leave the model, and what happens after that nobody counted.\n"
        "Read the figures within {}, or learn longer.\n",
        percent(leaves->value), counted(steps, "step"));
  }
  if (verification.states > kMaxSolvedStates) {
    text += fmt::format("not solved: chains of more than {} states are not factorised.\n", kMaxSolvedStates);
  }
  if (simulated &&
      (simulated->reward.low > verification.reward.high || simulated->reward.high < verification.reward.low)) {
    text += fmt::format(
        "The simulator earns {} than the chain promises, beyond both intervals: states that look alike to the sensors "
        "are\n"
        "one state of the chain, which therefore mixes what follows them. No interval for the counts holds that.\n",
        simulated->reward.value < verification.reward.value ? "less" : "more");
  }
  return text;
}

std::string to_text(const SizeBound& bound) {
  std::string text = fmt::format(
      "discounted by {}: {:.6g}; the policy {:.6g} ({:+.3g}), any policy at most {:.6g} ({:+.3g})\n", bound.gamma,
      bound.tree, bound.policy, bound.tree - bound.policy, bound.any_policy, bound.tree - bound.any_policy);
  const std::string size = counted(bound.conditions, "condition");
  if (bound.tree_is_best()) {
    text += fmt::format("  no tree of {} earns more: proved over all {:.0f} sets of them\n", size, bound.sets);
  } else if (bound.closed) {
    text += fmt::format("  no tree of {} earns more than {:.6g} ({:+.3g}): proved over all {:.0f} sets of them\n", size,
                        bound.most, bound.tree - bound.most, bound.sets);
  } else {
    text += fmt::format("  what the best tree of {} earns was not found: {:.4g} sets of them, {}\n", size, bound.sets,
                        bound.solved > 1 ? fmt::format("{} solutions were not enough (--bound)", bound.solved)
                                         : std::string("more than --bound"));
  }
  return text;
}

std::string to_text(const CheckedRule& checked, const Tree& tree, const Chain& chain, const Problem& problem) {
  const Vocabulary& vocabulary = chain.vocabulary();
  const RuleAnswer& answer = checked.answer;
  std::string text;
  if (answer.holds()) {
    text += fmt::format("yes  {}\n     for every observation; it is about {} of the chain\n", checked.rule.text,
                        counted(checked.states, "state"));
  } else {
    const Counterexample& broken = *answer.broken;
    text += fmt::format("no   {}\n     {} where {} (the rest may be anything)", checked.rule.text,
                        action_text(vocabulary, broken.action),
                        observation_text(vocabulary, broken.features, broken.matters));
    text += broken.writer < tree.size() ? fmt::format(", by node {}\n", broken.writer) : "\n";
    text += checked.seen ? fmt::format("     among the states that learning met: {}, {}\n",
                                       observation_text(vocabulary, chain.features_of(*checked.seen)),
                                       counted(chain.parts().visits[*checked.seen], "visit"))
                         : "     no state that learning met breaks it\n";
  }
  text += fmt::format("     {} of {} decide:\n", answer.ticked(), counted(tree.size(), "node"));
  std::vector<std::string> remarks;
  for (std::size_t node = 0; node < tree.size(); ++node) {
    const std::string role = role_text(answer.nodes[node], tree[node]);
    remarks.push_back(role.empty() ? "" : "<- " + role);
  }
  return text + numbered(tree, vocabulary, problem, remarks);
}

Json to_json(const Verification& verification, const std::optional<Simulated>& simulated) {
  Json events = Json::array();
  for (const EventFigures& event : verification.events) {
    events.push_back(json_of(event));
  }
  Json json = {{"steps", verification.settings.steps},
               {"resamples", verification.settings.resamples},
               {"seed", verification.settings.seed},
               {"interval", "95 % over draws of the counted rows from their Dirichlet posterior"},
               {"intervals_too_narrow", verification.intervals_too_narrow()},
               {"states", verification.states},
               {"reached", verification.reached},
               {"reward_per_episode", json_of(verification.reward)},
               {"policy_reward_per_episode", verification.policy_reward},
               {"most_reward_per_episode", verification.most_reward ? nlohmann::ordered_json(*verification.most_reward)
                                                                    : nlohmann::ordered_json()},
               {"reward_per_step", json_of(verification.reward_per_step)},
               {"events", events},
               {"leaves_by_untried_pair", json_of(verification.untried)},
               {"leaves_by_untried_pair_or_unseen_successor", json_of(verification.unseen)}};
  if (simulated) {
    json["simulator"] = {{"episodes", simulated->episodes},
                         {"collision", json_of(simulated->collision)},
                         {"unknown_state", json_of(simulated->unknown)},
                         {"reward_per_episode", json_of(simulated->reward)}};
  }
  return json;
}

Json to_json(const SizeBound& bound) {
  return {{"gamma", bound.gamma},
          {"tree", bound.tree},
          {"policy", bound.policy},
          {"any_policy", bound.any_policy},
          {"conditions", bound.conditions},
          {"sets_of_conditions", bound.sets},
          {"solved", bound.solved},
          {"closed", bound.closed},
          {"most", bound.most},
          {"tree_is_best", bound.tree_is_best()}};
}

Json to_json(const CheckedRule& checked, const Tree& tree, const Chain& chain) {
  const Vocabulary& vocabulary = chain.vocabulary();
  Json nodes = Json::array();
  for (std::size_t node = 0; node < tree.size(); ++node) {
    if (checked.answer.nodes[node].ticked) {
      nodes.push_back({{"node", node},
                       {"is", to_text(tree[node], vocabulary)},
                       {"role", role_text(checked.answer.nodes[node], tree[node])}});
    }
  }
  Json json = {{"rule", checked.rule.text},
               {"holds", checked.answer.holds()},
               {"states_of_the_chain", checked.states},
               {"nodes", nodes}};
  if (checked.answer.broken) {
    const Counterexample& broken = *checked.answer.broken;
    json["broken_by"] = {{"observation", observation_text(vocabulary, broken.features)},
                         {"matters", observation_text(vocabulary, broken.features, broken.matters)},
                         {"action", action_text(vocabulary, broken.action)},
                         {"node", broken.writer < tree.size() ? Json(broken.writer) : Json(nullptr)}};
    json["broken_by_state"] =
        checked.seen ? Json(observation_text(vocabulary, chain.features_of(*checked.seen))) : Json(nullptr);
  }
  return json;
}

}  // namespace coppice
