#include "coordinator/studio/page_trust.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <utility>

#include "common/tree/text.hpp"
#include "coordinator/learning/simulate.hpp"
#include "coordinator/studio/page_numbers.hpp"
#include "coordinator/trust/events.hpp"
#include "coordinator/trust/explanation_report.hpp"
#include "coordinator/trust/jumps.hpp"
#include "coordinator/trust/verification_report.hpp"

namespace coppice {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostListed = 50;  // disagreements that are listed; the rest is summed up
constexpr std::uint32_t kGroups = 5;     // branches that are suggested
constexpr double kGoodShare = 0.9;       // of the policy's reward that a tree must earn to be called good enough

Json json_of(const Estimate& estimate) {
  return {{"mean", page_number(estimate.mean)}, {"margin", page_number(estimate.margin)}};
}

Json json_of(const std::optional<ControllerScore>& score) {
  if (!score) {
    return nullptr;
  }
  return {{"episodes", score->episodes},
          {"steps", score->steps},
          {"agreement", json_of(score->agreement)},
          {"reward", json_of(score->reward)},
          {"collisions", json_of(score->collisions)},
          {"total_collisions", score->total_collisions},
          {"unknown_steps", score->unknown_steps}};
}

Result<std::optional<ControllerScore>> simulated(const World* world, const Chain& chain, const Tree* tree,
                                                 const SimulateSettings& settings, const SimulateProgress& go_on) {
  using Answer = std::optional<ControllerScore>;
  if (world == nullptr || settings.episodes == 0) {
    return Answer();
  }
  const auto episodes = tree != nullptr ? simulate_tree(*world, chain, *tree, settings, go_on)
                                        : simulate_policy(*world, chain, settings, go_on);
  return episodes.map([](const std::vector<EpisodeRecord>& records) { return Answer(controller_score(records)); });
}

std::string percent(double share) { return fmt::format("{:.1f} %", 100.0 * share); }

}  // namespace

Result<Promise> promise_of(const World* world, const std::string& world_kind, const Chain& chain, const Tree& tree,
                           const PromiseSettings& settings, const PageProgress& go_on) {
  const auto goes_on = [&](double share) { return !go_on || go_on(share); };
  Promise promise;
  // Of the whole, the simulator is a fifth; both controllers have the same episodes.
  const double of_episode = 0.1 / static_cast<double>(std::max<std::uint64_t>(settings.simulate.episodes, 1));
  double share = 0.0;
  const auto next_episode = [&] {
    share += of_episode;
    return goes_on(share);
  };
  auto by_tree = simulated(world, chain, &tree, settings.simulate, next_episode);
  if (!by_tree) {
    return tl::unexpected(std::move(by_tree).error());
  }
  promise.tree_simulated = *by_tree;
  auto by_policy = simulated(world, chain, nullptr, settings.simulate, next_episode);
  if (!by_policy) {
    return tl::unexpected(std::move(by_policy).error());
  }
  promise.policy_simulated = *by_policy;
  if (chain.states() > kMostTrustedStates || settings.resamples == 0) {
    return promise;
  }
  const VerifySettings verifying{
      .steps = settings.simulate.steps, .resamples = settings.resamples, .seed = settings.simulate.seed};
  Result<Verification> verified =
      verify(chain, tree, events_of_world(world_kind), rewards_of_world(world_kind), verifying,
             [&](std::uint32_t done) { return goes_on(0.2 + 0.8 * done / settings.resamples); });
  if (!verified) {
    return tl::unexpected(std::move(verified).error());
  }
  promise.tree = std::move(*verified);
  return promise;
}

Json to_json(const Promise& promise) {
  return {{"chain", promise.tree ? to_json(*promise.tree, std::nullopt) : Json(nullptr)},
          {"tree", json_of(promise.tree_simulated)},
          {"policy", json_of(promise.policy_simulated)}};
}

std::vector<std::string> shortfalls_of(const Promise& promise, const Json& figures, const Json& policy,
                                       const Json& view) {
  std::vector<std::string> found;
  const auto& tree = promise.tree_simulated;
  const auto& beside = promise.policy_simulated;
  if (tree && beside) {
    if (tree->total_collisions > beside->total_collisions) {
      found.push_back(fmt::format(
          "It is not safe: it collided {} times in {} simulated episodes; the policy collided {} times. Prove a rule "
          "that forbids it (\"never ... when ...\") and add the branch that is missing.",
          tree->total_collisions, tree->episodes, beside->total_collisions));
    }
    if (beside->reward.mean > 0.0 && tree->reward.mean < kGoodShare * beside->reward.mean) {
      found.push_back(
          fmt::format("It earns {} of what the policy earns in the simulator ({:.1f} +- {:.1f} of {:.1f} +- "
                      "{:.1f} an episode). More nodes, a search for return, or the branches below close "
                      "the gap.",
                      percent(tree->reward.mean / beside->reward.mean), tree->reward.mean, tree->reward.margin,
                      beside->reward.mean, beside->reward.margin));
    }
    if (tree->unknown_steps > 0) {
      found.push_back(fmt::format("It comes to places that learning never saw: {} of {} simulated steps.",
                                  tree->unknown_steps, tree->steps));
    }
  } else if (const double earned = figures["reward"], wanted = policy["reward"];
             wanted > 0.0 && earned < kGoodShare * wanted) {
    found.push_back(fmt::format("It earns {} of what the policy earns along the chain ({:.1f} of {:.1f} a walk).",
                                percent(earned / wanted), earned, wanted));
  }
  if (promise.tree && tree) {
    const Figure& chain = promise.tree->reward;
    const double low = tree->reward.mean - tree->reward.margin;
    const double high = tree->reward.mean + tree->reward.margin;
    if (low > chain.high || high < chain.low) {
      found.push_back(fmt::format(
          "The simulator earns {} than the chain promises ({:.1f} +- {:.1f} against {:.1f}), "
          "beyond both intervals: the chain takes states that look alike for one. 'coppice "
          "refine' counts what the tree meets and evolves on there.",
          tree->reward.mean < chain.value ? "less" : "more", tree->reward.mean, tree->reward.margin, chain.value));
    }
  }
  if (promise.tree) {
    for (const EventFigures& event : promise.tree->events) {
      if (event.name == "collision" && event.within.value > 0.0) {
        found.push_back(
            fmt::format("On the chain it collides within an episode with a probability of {} (95 % "
                        "interval {} to {}).",
                        percent(event.within.value), percent(event.within.low), percent(event.within.high)));
      }
    }
  }
  if (const double undecided = view["undecided"], steps = view["steps"]; undecided > 0.0) {
    found.push_back(
        fmt::format("In {} of the steps no node decides: the agent then holds still.", percent(undecided / steps)));
  }
  return found;
}

std::vector<std::string> default_rules(const std::string& world_kind) {
  std::vector<std::string> rules{"never none"};
  if (world_kind == "uav" || world_kind == "battery") {
    rules.emplace_back("never move when s3=0");
  }
  return rules;
}

Json rule_json(const std::string& text, const Tree& tree, const Chain& chain) {
  const Result<Rule> rule = parse_rule(text, chain.vocabulary());
  if (!rule) {
    return {{"rule", text}, {"error", rule.error().message}};
  }
  const Result<CheckedRule> checked = check_on(*rule, tree, chain);
  if (!checked) {
    return {{"rule", text}, {"error", checked.error().message}};
  }
  Json json = {{"rule", text}, {"holds", checked->answer.holds()}, {"states", checked->states}};
  Json roles = Json::array();
  for (const NodeRole& role : checked->answer.nodes) {
    roles.push_back(!role.ticked ? 0 : role.last_word ? 2 : 1);
  }
  json["roles"] = roles;  // [nodes] 0 never ticked where the rule applies, 1 ticked, 2 has the last word
  if (checked->answer.broken) {
    const Counterexample& broken = *checked->answer.broken;
    json["broken_by"] = {{"features", broken.features},
                         {"matters", broken.matters},
                         {"action", broken.action == kNoAction ? Json(-1) : Json(index_of(broken.action))},
                         {"node", broken.writer < tree.size() ? Json(broken.writer) : Json(nullptr)}};
    json["seen"] = nullptr;
    if (checked->seen) {
      const auto features = chain.features_of(*checked->seen);
      json["seen"] = {{"state", *checked->seen},
                      {"features", std::vector<std::uint8_t>(features.begin(), features.end())},
                      {"visits", chain.parts().visits[*checked->seen]}};
    }
  }
  return json;
}

Json disagreements_json(const Chain& chain, const Tree& tree, std::uint32_t steps) {
  ExplainSettings settings;
  settings.steps = steps;
  settings.groups = kGroups;
  const bool small = chain.states() <= kMostTrustedStates;
  if (!small) {
    settings.groups = 0;
  }
  const ExplainReport report = explain_report(chain, tree, settings);
  const Explanation& explanation = report.explanation;
  Json states = Json::array();
  for (std::size_t i = 0; i < std::min(kMostListed, explanation.disagreements.size()); ++i) {
    const Disagreement& d = explanation.disagreements[i];
    const auto features = chain.features_of(d.state);
    states.push_back({{"state", d.state},
                      {"features", std::vector<std::uint8_t>(features.begin(), features.end())},
                      {"visits", page_number(d.visits)},
                      {"regret", page_number(d.regret)},
                      {"cost", page_number(d.cost())},
                      {"policy", index_of(d.policy)},
                      {"tree", d.tree == kNoAction ? Json(-1) : Json(index_of(d.tree))},
                      {"node", d.writer == kTickEnds ? Json(nullptr) : Json(d.writer)}});
  }
  Json branches = Json::array();
  for (std::size_t i = 0; i < explanation.groups.size(); ++i) {
    const Group& group = explanation.groups[i];
    const Suggestion& suggestion = report.suggestions[i];
    branches.push_back({{"branch", to_text(suggestion.branch, chain.vocabulary())},
                        {"saved", page_number(group.saved)},
                        {"states", group.states},
                        {"differing", group.disagreements},
                        {"mended", group.mended},
                        {"spoilt", group.spoilt},
                        {"edit", suggestion.edit},
                        {"agreement", page_number(suggestion.alone.along_chain.agreement)},
                        {"coverage", page_number(suggestion.alone.coverage())},
                        {"reward", page_number(suggestion.alone.along_chain.reward)}});
  }
  return {{"total", explanation.disagreements.size()},
          {"cost", page_number(explanation.cost)},
          {"steps", steps},
          {"costliest", states},
          {"branches", branches},
          {"complete", explanation.complete},
          {"searched", small}};
}

}  // namespace coppice
