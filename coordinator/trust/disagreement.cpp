#include "coordinator/trust/disagreement.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <numeric>
#include <optional>

#include "common/chain/exact.hpp"
#include "common/check.hpp"
#include "coordinator/learning/world.hpp"
#include "coordinator/report/on_chain.hpp"
#include "coordinator/trust/jumps.hpp"

namespace coppice {
namespace {

constexpr std::uint32_t kMostTests = 8;
constexpr std::uint32_t kMostGroups = 1000;
// A shorter conjunction is taken when it saves at least this share of what the longest saves.
constexpr double kShortEnough = 0.95;
// A group that saves less of the cost is not worth a branch.
constexpr double kWorthwhile = 0.001;

std::vector<double> visits_of(const Chain& chain, const std::vector<std::uint8_t>& actions, std::uint32_t steps) {
  std::vector<double> visits(chain.states(), 0.0);
  ExactOccupancy exact(chain);
  const Occupancy& occupancy = exact.over_steps({.actions = actions, .others = {}, .others_share = 0.0}, steps);
  for (std::size_t i = 0; i < occupancy.states.size(); ++i) {
    visits[occupancy.states[i]] = occupancy.visits[i];
  }
  return visits;
}

std::vector<double> weights_of(const Chain& chain, const std::vector<std::uint8_t>& of_tree,
                               const std::vector<std::uint8_t>& of_policy, const ExplainSettings& settings) {
  switch (settings.weighting) {
    case Weighting::tree:
      return visits_of(chain, of_tree, settings.steps);
    case Weighting::policy:
      return visits_of(chain, of_policy, settings.steps);
    case Weighting::learning: {
      const auto& visits = chain.parts().visits;
      const double all = std::accumulate(visits.begin(), visits.end(), 0.0);
      std::vector<double> weights;
      weights.reserve(visits.size());
      for (const std::uint64_t count : visits) {
        weights.push_back(all == 0.0 ? 0.0 : static_cast<double>(count) / all * settings.steps);
      }
      return weights;
    }
    case Weighting::states:
      break;
  }
  return std::vector<double>(chain.states(), 1.0);
}

// Q of what the tree does; nothing done for ever is worth 0.
double value_of(const Chain& chain, std::size_t state, std::uint8_t action) {
  const std::size_t taken = chain.taken(state, action);
  return taken < chain.actions() ? chain.parts().q[state * chain.actions() + taken] : 0.0;
}

// All conditions that the vocabulary allows, less those that always hold.
std::vector<Node> all_tests(const Vocabulary& vocabulary) {
  std::vector<Node> tests;
  for (std::size_t f = 0; f < vocabulary.features.size(); ++f) {
    const Feature& feature = vocabulary.features[f];
    for (const Op op : {Op::equal, Op::less_equal}) {
      for (const std::uint8_t value : feature.values) {
        const bool always = feature.values.size() == 1 || (op == Op::less_equal && value == feature.values.back());
        if (feature.admits(op) && !always) {
          tests.push_back(Node::condition(f, op, value));
        }
      }
    }
  }
  return tests;
}

// The search for the group that saves most.
class GroupSearch {
 public:
  // gains: [states x actions] what it saves to take the action in the state.
  GroupSearch(const Chain& chain, const std::vector<Node>& tests, const std::vector<double>& gains,
              std::size_t most_tests)
      : chain_(chain), tests_(tests), gains_(gains), best_(most_tests + 1) {}

  std::optional<Group> run() {
    std::vector<std::uint32_t> states;
    for (std::uint32_t state = 0; state < chain_.states(); ++state) {
      const auto begin = gains_.begin() + static_cast<std::ptrdiff_t>(state * chain_.actions());
      if (std::any_of(begin, begin + static_cast<std::ptrdiff_t>(chain_.actions()),
                      [](double g) { return g != 0.0; })) {
        states.push_back(state);  // the others change no sum
      }
    }
    std::vector<Node> chosen;
    descend(states, 0, chosen);
    double most = 0.0;
    for (const std::optional<Group>& group : best_) {
      most = group ? std::max(most, group->saved) : most;
    }
    for (const std::optional<Group>& group : best_) {
      if (group && group->saved > 0.0 && group->saved >= kShortEnough * most) {
        return group;
      }
    }
    return std::nullopt;
  }

  bool complete() const { return tried_ < kMostConjunctions; }

 private:
  // Makes the most of the conjunction `chosen`, which holds in `states`, and of those that go on from it.
  void descend(const std::vector<std::uint32_t>& states, std::size_t next_test, std::vector<Node>& chosen) {
    if (++tried_ >= kMostConjunctions) {
      return;
    }
    const std::size_t actions = chain_.actions();
    std::vector<double> saved(actions, 0.0);
    std::vector<double> bound(actions, 0.0);
    for (const std::uint32_t state : states) {
      for (std::size_t action = 0; action < actions; ++action) {
        const double gain = gains_[state * actions + action];
        saved[action] += gain;
        bound[action] += std::max(gain, 0.0);
      }
    }
    const auto most = std::max_element(saved.begin(), saved.end());
    std::optional<Group>& best = best_[chosen.size()];
    if (!chosen.empty() && (!best || *most > best->saved)) {
      best =
          Group{.tests = chosen, .action = ActionId{static_cast<std::uint8_t>(most - saved.begin())}, .saved = *most};
    }
    const double hope = *std::max_element(bound.begin(), bound.end());
    if (chosen.size() + 1 == best_.size() || !can_improve(hope, chosen.size())) {
      return;
    }
    for (std::size_t test = next_test; test < tests_.size(); ++test) {
      std::vector<std::uint32_t> kept;
      for (const std::uint32_t state : states) {
        if (holds(tests_[test], chain_.features_of(state)[tests_[test].index])) {
          kept.push_back(state);
        }
      }
      // A test that changes nothing makes the conjunction longer, no better.
      if (!kept.empty() && (kept.size() < states.size() || chosen.empty())) {
        chosen.push_back(tests_[test]);
        descend(kept, test + 1, chosen);
        chosen.pop_back();
      }
    }
  }

  // Whether something longer than `tests` could still be the best of its length.
  bool can_improve(double hope, std::size_t tests) const {
    for (std::size_t length = tests + 1; length < best_.size(); ++length) {
      if (hope > (best_[length] ? best_[length]->saved : 0.0)) {
        return true;
      }
    }
    return false;
  }

  const Chain& chain_;
  const std::vector<Node>& tests_;
  const std::vector<double>& gains_;
  std::vector<std::optional<Group>> best_;  // by number of tests
  std::size_t tried_ = 0;
};

bool all_hold(const std::vector<Node>& tests, std::span<const std::uint8_t> features) {
  return std::all_of(tests.begin(), tests.end(), [&](const Node& test) { return holds(test, features[test.index]); });
}

}  // namespace

Result<void> check_settings(const ExplainSettings& settings) {
  if (settings.steps < 1 || settings.steps > kMaxEpisodeSteps) {
    return bad_input(fmt::format("--steps is {}: expected 1 to {}", settings.steps, kMaxEpisodeSteps));
  }
  if (settings.tests < 1 || settings.tests > kMostTests) {
    return bad_input(fmt::format("--tests is {}: expected 1 to {}", settings.tests, kMostTests));
  }
  if (settings.groups > kMostGroups) {
    return bad_input(fmt::format("--groups is {}: expected 0 to {}", settings.groups, kMostGroups));
  }
  return {};
}

Explanation explain(const Chain& chain, const Tree& tree, const ExplainSettings& settings) {
  const std::size_t actions = chain.actions();
  ChainActions of_tree = actions_of(chain, tree);
  const ChainActions of_policy = actions_of_policy(chain);
  const std::vector<double> weights = weights_of(chain, of_tree, of_policy, settings);
  const std::vector<Jump> jumps = jumps_of(tree);

  Explanation result{.settings = settings, .states = chain.states(), .cost = 0.0, .disagreements = {}, .groups = {}};
  std::vector<double> gains(chain.states() * actions, 0.0);
  for (std::size_t state = 0; state < chain.states(); ++state) {
    const double now = value_of(chain, state, of_tree[state]);
    for (std::size_t action = 0; action < actions; ++action) {
      gains[state * actions + action] = weights[state] * (chain.parts().q[state * actions + action] - now);
    }
    if (of_tree[state] == of_policy[state] || chain.is_terminal(state)) {
      continue;
    }
    result.disagreements.push_back({.state = state,
                                    .visits = weights[state],
                                    .regret = value_of(chain, state, of_policy[state]) - now,
                                    .policy = chain.policy(state),
                                    .tree = of_tree[state] < actions ? ActionId{of_tree[state]} : kNoAction,
                                    .writer = last_writer(tree, jumps, chain.features_of(state))});
    result.cost += result.disagreements.back().cost();
  }
  std::stable_sort(result.disagreements.begin(), result.disagreements.end(),
                   [](const Disagreement& a, const Disagreement& b) { return a.cost() > b.cost(); });

  const std::vector<Node> tests = all_tests(chain.vocabulary());
  while (result.groups.size() < settings.groups) {  // ends: a group is added, or none is found
    GroupSearch search(chain, tests, gains, settings.tests);
    std::optional<Group> group = search.run();
    result.complete = result.complete && search.complete();
    if (!group || group->saved < kWorthwhile * result.cost) {
      break;
    }
    for (std::size_t state = 0; state < chain.states(); ++state) {
      if (!all_hold(group->tests, chain.features_of(state))) {
        continue;
      }
      const auto action = static_cast<std::uint8_t>(index_of(group->action));
      const bool agrees = of_tree[state] == of_policy[state];
      ++group->states;
      group->disagreements += agrees ? 0U : 1U;
      group->mended += !agrees && of_policy[state] == action ? 1U : 0U;
      group->spoilt += agrees && of_policy[state] != action ? 1U : 0U;
      // From now on this is what happens there.
      const double mended = gains[state * actions + action];
      for (std::size_t other = 0; other < actions; ++other) {
        gains[state * actions + other] -= mended;
      }
      of_tree[state] = action;
    }
    result.groups.push_back(std::move(*group));
  }
  return result;
}

Tree branch_of(const Group& group) {
  std::vector<Node> nodes{Node::composite(NodeKind::sequence, group.tests.size() + 2)};
  nodes.insert(nodes.end(), group.tests.begin(), group.tests.end());
  nodes.push_back(Node::action(group.action));
  return *Tree::from_nodes(std::move(nodes));
}

Tree with_branch(const Tree& tree, const Tree& branch) {
  const bool inside = tree[0].kind == NodeKind::selector;
  std::vector<Node> nodes{Node::composite(NodeKind::selector, tree.size() + branch.size() + (inside ? 0 : 1))};
  nodes.insert(nodes.end(), branch.nodes().begin(), branch.nodes().end());
  nodes.insert(nodes.end(), tree.nodes().begin() + (inside ? 1 : 0), tree.nodes().end());
  return Tree::from_nodes(std::move(nodes)).value_or(tree);  // a tree at the limits of size or depth takes no branch
}

}  // namespace coppice
