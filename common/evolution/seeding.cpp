#include "common/evolution/seeding.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <numeric>
#include <string_view>
#include <vector>

#include "common/check.hpp"
#include "common/evolution/breeding.hpp"
#include "common/tree/condition.hpp"
#include "common/tree/text.hpp"

namespace coppice {
namespace {

constexpr std::size_t kNodesPerBranch = 3;
constexpr std::size_t kMaxBranches = 12;
constexpr char kBetweenFounders = ';';

std::vector<Node> all_conditions(const Vocabulary& vocabulary) {
  std::vector<Node> conditions;
  for (std::size_t feature = 0; feature < vocabulary.features.size(); ++feature) {
    for (const Op op : {Op::equal, Op::less_equal}) {
      for (const std::uint8_t value : vocabulary.features[feature].values) {
        if (vocabulary.features[feature].admits(op)) {
          conditions.push_back(Node::condition(feature, op, value));
        }
      }
    }
  }
  return conditions;
}

struct Branch {
  Node condition;
  ActionId action;
};

// (selector (sequence condition action) ... otherwise)
Tree tree_of(const std::vector<Branch>& branches, ActionId otherwise) {
  std::vector<Node> nodes = {Node::composite(NodeKind::selector, kNodesPerBranch * branches.size() + 2)};
  for (const Branch& branch : branches) {
    nodes.push_back(Node::composite(NodeKind::sequence, kNodesPerBranch));
    nodes.push_back(branch.condition);
    nodes.push_back(Node::action(branch.action));
  }
  nodes.push_back(Node::action(otherwise));
  auto tree = Tree::from_nodes(std::move(nodes));
  COPPICE_CHECK(tree.has_value());
  return std::move(*tree);
}

class GreedyList {
 public:
  GreedyList(const Chain& chain, Stream& stream) : chain_(chain), stream_(stream), undecided_(chain.states(), true) {
    const auto& visits = chain.parts().visits;
    const double all_visits = std::accumulate(visits.begin(), visits.end(), 0.0);
    const double by_visits = static_cast<double>(stream.below(101)) / 100.0;
    for (std::size_t s = 0; s < chain.states(); ++s) {
      const double share = all_visits > 0.0 ? static_cast<double>(visits[s]) / all_visits : 0.0;
      weight_.push_back(by_visits * share + (1.0 - by_visits) / static_cast<double>(chain.states()));
    }
  }

  Tree grow(std::size_t branches) {
    const std::vector<double> of_all = weights_by_action([](std::size_t) { return true; });
    const auto otherwise = static_cast<std::size_t>(std::max_element(of_all.begin(), of_all.end()) - of_all.begin());
    const std::vector<Node> conditions = all_conditions(chain_.vocabulary());
    std::vector<Branch> list;
    while (list.size() < branches && add_best(conditions, otherwise, list)) {
    }
    if (list.empty()) {  // nothing to gain: any branch will do
      list.push_back({conditions[stream_.below(conditions.size())], action_at(otherwise)});
    }
    return tree_of(list, action_at(otherwise));
  }

 private:
  static ActionId action_at(std::size_t index) { return ActionId{static_cast<std::uint8_t>(index)}; }

  // What the undecided states that are `in` weigh, by the policy's action there. [actions]
  template <typename In>
  std::vector<double> weights_by_action(const In& in) const {
    std::vector<double> sums(chain_.actions(), 0.0);
    for (std::size_t s = 0; s < chain_.states(); ++s) {
      if (undecided_[s] && in(s)) {
        sums[index_of(chain_.policy(s))] += weight_[s];
      }
    }
    return sums;
  }

  // False: no branch gains anything.
  bool add_best(const std::vector<Node>& conditions, std::size_t otherwise, std::vector<Branch>& list) {
    double best_gain = 0.0;
    Branch best{};
    for (const Node& condition : conditions) {
      if (stream_.below(2) == 0) {
        continue;
      }
      const std::vector<double> sums =
          weights_by_action([&](std::size_t s) { return holds(condition, chain_.features_of(s)); });
      for (std::size_t action = 0; action < sums.size(); ++action) {
        const double gain = sums[action] - sums[otherwise];
        if (action != otherwise && gain > best_gain) {
          best_gain = gain;
          best = {condition, action_at(action)};
        }
      }
    }
    if (best_gain <= 0.0) {
      return false;
    }
    list.push_back(best);
    for (std::size_t s = 0; s < chain_.states(); ++s) {
      undecided_[s] = undecided_[s] && !holds(best.condition, chain_.features_of(s));
    }
    return true;
  }

  const Chain& chain_;
  Stream& stream_;
  std::vector<bool> undecided_;  // [states]
  std::vector<double> weight_;   // [states]
};

}  // namespace

std::optional<Tree> seed_tree(Seeding seeding, const Chain& chain, const TreeShape& shape, Stream& stream) {
  COPPICE_CHECK(seeding != Seeding::none);
  if (shape.max_depth < 2 || shape.max_nodes < kNodesPerBranch + 2 || shape.max_conditions == 0) {
    return std::nullopt;
  }
  const std::size_t most =
      std::min({shape.max_children - 1, (shape.max_nodes - 2) / kNodesPerBranch, shape.max_conditions, kMaxBranches});
  const std::size_t branches = 1 + stream.below(most);
  if (seeding == Seeding::greedy) {
    return GreedyList(chain, stream).grow(branches);
  }
  const std::vector<Node> conditions = all_conditions(chain.vocabulary());
  const auto any_action = [&] { return ActionId{static_cast<std::uint8_t>(stream.below(chain.actions()))}; };
  std::vector<Branch> list;
  for (std::size_t i = 0; i < branches; ++i) {
    const Node condition = conditions[stream.below(conditions.size())];
    list.push_back({condition, any_action()});
  }
  return tree_of(list, any_action());
}

Result<std::vector<Tree>> founders_of(const GaConfig& ga, const Vocabulary& vocabulary) {
  std::vector<Tree> founders;
  if (ga.founders.empty()) {
    return founders;
  }
  const Breeding breeding(vocabulary, ga.shape());
  std::string_view rest = ga.founders;
  for (bool more = true; more;) {
    const std::string name = fmt::format("tree {}", founders.size() + 1);
    const std::size_t end = rest.find(kBetweenFounders);
    more = end != std::string_view::npos;
    auto tree = parse_tree(rest.substr(0, end), vocabulary);
    rest.remove_prefix(more ? end + 1 : rest.size());
    if (!tree) {
      return in_context(name, tree.error());
    }
    if (!breeding.within_limits(*tree)) {
      return bad_input(
          fmt::format("{}, of {} nodes, is outside the limits: expected ga.max_depth ({}), 2 to "
                      "ga.max_children ({}) children and ga.max_nodes ({}) to hold",
                      name, tree->size(), ga.max_depth, ga.max_children, ga.max_nodes));
    }
    founders.push_back(std::move(*tree));
    if (founders.size() > ga.population) {
      return bad_input(
          fmt::format("more trees than ga.population, which is {}: expected as many at most", ga.population));
    }
  }
  return founders;
}

std::string founders_text(std::span<const Tree> trees, const Vocabulary& vocabulary) {
  std::string text;
  for (const Tree& tree : trees) {
    text += (text.empty() ? "" : std::string(1, kBetweenFounders) + " ") + to_text(tree, vocabulary);
  }
  return text;
}

}  // namespace coppice
