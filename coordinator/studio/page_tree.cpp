#include "coordinator/studio/page_tree.hpp"

#include <algorithm>
#include <numeric>

#include "common/tree/text.hpp"
#include "coordinator/report/on_chain.hpp"
#include "coordinator/studio/page_numbers.hpp"
#include "coordinator/studio/tree_view.hpp"

namespace coppice {
namespace {

using Json = nlohmann::ordered_json;

// The figures of expected_score(), from visits that are known already.
Json figures_json(const Chain& chain, const ChainActions& actions, const std::vector<double>& visits,
                  std::uint32_t steps) {
  double agreement = 0.0;
  double reward = 0.0;
  for (std::size_t state = 0; state < chain.states(); ++state) {
    if (visits[state] == 0.0) {
      continue;
    }
    const bool agrees = actions[state] == index_of(chain.policy(state)) || chain.is_terminal(state);
    agreement += agrees ? visits[state] : 0.0;
    if (const std::size_t taken = chain.taken(state, actions[state]); taken < chain.actions()) {
      reward += visits[state] * chain.mean_reward(state * chain.actions() + taken);
    }
  }
  const std::size_t matching = matching_states(chain, actions);
  return {{"matching_states", matching},
          {"coverage", page_number(static_cast<double>(matching) / static_cast<double>(chain.states()))},
          {"agreement", page_number(agreement / steps)},
          {"reward", page_number(reward)}};
}

Json feature_json(const Feature& feature, const FeatureLegend& legend) {
  Json json = {{"name", feature.name},
               {"values", feature.values},
               {"equal", feature.admits_equal},
               {"less_equal", feature.admits_less_equal}};
  if (!legend.label.empty()) {
    json["label"] = legend.label;
  }
  if (!legend.unit.empty()) {
    json["unit"] = legend.unit;
  }
  if (!legend.values.empty()) {
    json["labels"] = Json::array();
    for (const std::uint8_t value : feature.values) {
      const auto label = legend.values.find(value);
      json["labels"].push_back(label == legend.values.end() ? Json(nullptr) : Json(label->second));
    }
  }
  if (feature.scale != Scale::plain) {
    json["texts"] = Json::array();
    json["readings"] = Json::array();
    for (const std::uint8_t value : feature.values) {
      json["texts"].push_back(feature.number_text(value));
      json["readings"].push_back(feature.reading_text(value));
    }
  }
  return json;
}

Json size_json(const Tree& tree) {
  std::size_t conditions = 0;
  std::size_t actions = 0;
  for (const Node& node : tree.nodes()) {
    conditions += node.kind == NodeKind::condition ? 1U : 0U;
    actions += node.kind == NodeKind::action ? 1U : 0U;
  }
  return {{"nodes", tree.size()}, {"conditions", conditions}, {"actions", actions}, {"depth", tree.depth()}};
}

// Marks the `most` states of the highest weight, ties to the lower index.
void mark_heaviest(const std::vector<double>& weights, std::size_t most, std::vector<bool>& marked) {
  std::vector<std::uint32_t> order(weights.size());
  std::iota(order.begin(), order.end(), 0U);
  most = std::min(most, order.size());
  std::partial_sort(
      order.begin(), order.begin() + static_cast<std::ptrdiff_t>(most), order.end(),
      [&](std::uint32_t a, std::uint32_t b) { return weights[a] != weights[b] ? weights[a] > weights[b] : a < b; });
  for (std::size_t i = 0; i < most; ++i) {
    marked[order[i]] = true;
  }
}

double share_of(const std::vector<double>& weights, const std::vector<std::size_t>& states) {
  const double all = std::accumulate(weights.begin(), weights.end(), 0.0);
  double part = 0.0;
  for (const std::size_t state : states) {
    part += weights[state];
  }
  return all > 0.0 ? part / all : 1.0;
}

}  // namespace

Json vocabulary_json(const Vocabulary& vocabulary, const Problem& problem) {
  Json features = Json::array();
  for (std::size_t f = 0; f < vocabulary.features.size(); ++f) {
    features.push_back(feature_json(vocabulary.features[f], problem.features[f]));
  }
  Json actions = Json::array();
  for (std::size_t a = 0; a < vocabulary.actions.size(); ++a) {
    Json action = {{"name", vocabulary.actions[a]}};
    if (!problem.action_labels[a].empty()) {
      action["label"] = problem.action_labels[a];
    }
    actions.push_back(std::move(action));
  }
  return {{"features", features}, {"actions", actions}};
}

Json tree_json(const Chain& chain, const Tree& tree, std::uint32_t steps) {
  const ChainActions actions = actions_of(chain, tree);
  const std::vector<double> visits = expected_visits(chain, actions, steps);
  return {{"text", to_text(tree, chain.vocabulary())},
          {"size", size_json(tree)},
          {"figures", figures_json(chain, actions, visits, steps)},
          {"view", to_json(view_of(chain, tree, visits))}};
}

Json policy_json(const Chain& chain, std::uint32_t steps) {
  const ChainActions actions = actions_of_policy(chain);
  return figures_json(chain, actions, expected_visits(chain, actions, steps), steps);
}

Json states_json(const Chain& chain, const std::vector<double>& tree_visits, const std::vector<double>& policy_visits) {
  const auto& parts = chain.parts();
  const std::vector<double> learning(parts.visits.begin(), parts.visits.end());
  std::vector<bool> marked(chain.states(), chain.states() <= kMostPageStates);
  if (chain.states() > kMostPageStates) {
    for (const auto* weights : {&tree_visits, &policy_visits, &learning}) {
      mark_heaviest(*weights, kMostPageStates / 3, marked);
    }
  }
  std::vector<std::size_t> shown;
  for (std::size_t state = 0; state < chain.states(); ++state) {
    if (marked[state]) {
      shown.push_back(state);
    }
  }
  Json features = Json::array();
  Json policy = Json::array();
  Json by_tree = Json::array();
  Json by_policy = Json::array();
  Json in_learning = Json::array();
  Json q = Json::array();
  Json terminal = Json::array();
  for (const std::size_t state : shown) {
    if (chain.is_terminal(state)) {
      terminal.push_back(policy.size());
    }
    for (const std::uint8_t value : chain.features_of(state)) {
      features.push_back(value);
    }
    policy.push_back(index_of(chain.policy(state)));
    by_tree.push_back(page_number(tree_visits[state]));
    by_policy.push_back(page_number(policy_visits[state]));
    in_learning.push_back(parts.visits[state]);
    for (std::size_t action = 0; action < chain.actions(); ++action) {
      q.push_back(page_number(parts.q[state * chain.actions() + action]));
    }
  }
  return {{"total", chain.states()},
          {"index", shown},
          {"features", features},
          {"policy", policy},
          {"tree_visits", by_tree},
          {"policy_visits", by_policy},
          {"learning_visits", in_learning},
          {"q", q},
          {"terminal", terminal},
          {"tree_share", page_number(share_of(tree_visits, shown))},
          {"policy_share", page_number(share_of(policy_visits, shown))}};
}

}  // namespace coppice
