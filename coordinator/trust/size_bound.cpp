#include "coordinator/trust/size_bound.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "common/chain/exact.hpp"
#include "common/chain/policy_value.hpp"
#include "common/tree/condition.hpp"
#include "common/tree/tree_size.hpp"
#include "coordinator/report/on_chain.hpp"

namespace coppice {
namespace {

constexpr std::uint8_t kFree = 0xFF;     // a state whose action is not fixed
constexpr double kRounding = 1e-9;       // of a return, relative
constexpr int kMostImprovements = 1000;  // of policy iteration, which needs a dozen

double scale_of(double value) { return std::max(1e-9, std::abs(value)); }

// What each action earns in each state. [states x (actions + 1)]
std::vector<double> rewards_table(const Chain& chain) {
  std::vector<double> rewards;
  rewards.reserve(chain.states() * (chain.actions() + 1));
  for (std::size_t s = 0; s < chain.states(); ++s) {
    for (std::size_t a = 0; a <= chain.actions(); ++a) {
      const std::size_t taken = chain.taken(s, a);
      rewards.push_back(taken == chain.actions() ? 0.0 : chain.mean_reward(s * chain.actions() + taken));
    }
  }
  return rewards;
}

// The ways in which one condition tells states apart, each once: [states] of 0 and 1, 0 in the first state.
std::vector<std::vector<std::uint8_t>> splits_of(const Chain& chain) {
  std::set<std::vector<std::uint8_t>> splits;
  for (std::size_t f = 0; f < chain.vocabulary().features.size(); ++f) {
    const Feature& feature = chain.vocabulary().features[f];
    for (const std::uint8_t value : feature.values) {
      for (const Op op : {Op::equal, Op::less_equal}) {
        if (!feature.admits(op)) {
          continue;
        }
        const Node condition = Node::condition(f, op, value);
        std::vector<std::uint8_t> split;
        const bool first = holds(condition, chain.features_of(0));
        split.reserve(chain.states());
        for (std::size_t s = 0; s < chain.states(); ++s) {
          split.push_back(holds(condition, chain.features_of(s)) == first ? 0 : 1);
        }
        if (std::find(split.begin(), split.end(), 1) != split.end()) {
          splits.insert(std::move(split));
        }
      }
    }
  }
  return {splits.begin(), splits.end()};
}

double sets_of(std::size_t from, std::size_t count) {
  double sets = 1.0;
  for (std::size_t i = 0; i < count; ++i) {
    sets *= static_cast<double>(from - i) / static_cast<double>(i + 1);
  }
  return std::round(sets);
}

class SizeSearch {
 public:
  SizeSearch(const Chain& chain, double gamma, std::uint64_t effort, const std::function<bool()>& go_on)
      : chain_(chain),
        gamma_(gamma),
        effort_(effort),
        go_on_(go_on),
        stride_(chain.actions() + 1),
        rewards_(rewards_table(chain)),
        splits_(splits_of(chain)),
        value_(chain),
        fixed_(chain.states(), kFree),
        cell_(chain.states(), 0) {}

  std::optional<double> return_of(const std::vector<std::uint8_t>& actions) {
    return value_.solve(actions, rewards_, gamma_) ? std::optional(value_.expected_return()) : std::nullopt;
  }

  // What the best policy with these states fixed earns; `actions` becomes that policy.
  double optimum(std::vector<std::uint8_t>& actions) {
    ++solved_;
    for (int i = 0; i < kMostImprovements && value_.solve(actions, rewards_, gamma_); ++i) {
      value_.advantages(rewards_, advantages_);
      const double least = kRounding * (1.0 - gamma_) * scale_of(value_.expected_return());
      bool changed = false;
      for (std::size_t s = 0; s < actions.size(); ++s) {
        if (fixed_[s] != kFree) {
          continue;
        }
        const double* const row = advantages_.data() + s * stride_;
        const auto best = static_cast<std::uint8_t>(std::max_element(row, row + stride_) - row);
        if (best != actions[s] && row[best] > row[actions[s]] + least) {
          actions[s] = best;
          changed = true;
        }
      }
      if (!changed) {
        return value_.expected_return();
      }
    }
    return std::numeric_limits<double>::infinity();  // not solved: nothing is ruled out
  }

  const std::vector<std::vector<std::uint8_t>>& splits() const { return splits_; }
  std::uint64_t solved() const { return solved_; }
  bool interrupted() const { return interrupted_; }

  // The most that a policy earns which some `count` conditions tell all it needs, given one that earns `known`.
  // Nothing: the effort is spent.
  std::optional<double> most(std::size_t count, const std::vector<std::uint8_t>& best_policy, double known) {
    most_ = known;
    root_ = best_policy;
    choose(0, std::min(count, splits_.size()), 0);
    return spent_ ? std::nullopt : std::optional(most_);
  }

 private:
  bool out_of_effort() {
    interrupted_ = interrupted_ || (go_on_ && !go_on_());
    spent_ = spent_ || interrupted_ || solved_ >= effort_;
    return spent_;
  }

  // All sets of `left` more splits from `first` on; `bit`: how many there are so far.
  void choose(std::size_t first, std::size_t left, std::size_t bit) {
    if (spent_) {
      return;
    }
    if (left == 0) {
      std::vector<std::uint8_t> policy = root_;
      static_cast<void>(value_.solve(policy, rewards_, gamma_));  // the occupancy to begin with
      branch(policy);
      return;
    }
    for (std::size_t i = first; i + left <= splits_.size(); ++i) {
      for (std::size_t s = 0; s < cell_.size(); ++s) {
        cell_[s] |= static_cast<std::uint32_t>(splits_[i][s]) << bit;
      }
      choose(i + 1, left - 1, bit + 1);
      for (std::size_t s = 0; s < cell_.size(); ++s) {
        cell_[s] &= ~(1U << bit);
      }
    }
  }

  // The cell of the set in which `policy` acts most unlike itself, and its actions, the most usual first. No actions:
  // it never does. REQUIRES: value_ was solved for it.
  struct Conflict {
    std::uint32_t cell = 0;
    std::vector<std::uint8_t> actions;
  };
  Conflict conflict_in(const std::vector<std::uint8_t>& policy) {
    const auto cells = static_cast<std::size_t>(*std::max_element(cell_.begin(), cell_.end())) + 1;
    weights_.assign(cells * stride_, 0.0);
    for (std::size_t s = 0; s < policy.size(); ++s) {
      if (fixed_[s] == kFree) {
        weights_[cell_[s] * stride_ + policy[s]] += value_.occupancy()[s];
      }
    }
    Conflict worst;
    double most = 0.0;
    for (std::size_t cell = 0; cell < cells; ++cell) {
      const double* const row = weights_.data() + cell * stride_;
      double rest = -*std::max_element(row, row + stride_);
      for (std::size_t a = 0; a < stride_; ++a) {
        rest += row[a];
      }
      if (rest > most) {
        most = rest;
        worst.cell = static_cast<std::uint32_t>(cell);
      }
    }
    if (most > 0.0) {
      const double* const row = weights_.data() + worst.cell * stride_;
      for (std::size_t a = 0; a < stride_; ++a) {
        worst.actions.push_back(static_cast<std::uint8_t>(a));
      }
      std::stable_sort(worst.actions.begin(), worst.actions.end(),
                       [&](std::uint8_t a, std::uint8_t b) { return row[a] > row[b]; });
    }
    return worst;
  }

  // `policy`: the best with what is fixed, for which value_ was solved.
  void branch(const std::vector<std::uint8_t>& policy) {
    const double promised = value_.expected_return();
    const Conflict conflict = conflict_in(policy);
    if (conflict.actions.empty()) {
      most_ = std::max(most_, promised);
      return;
    }
    for (const std::uint8_t action : conflict.actions) {
      if (out_of_effort()) {
        return;
      }
      std::vector<std::uint8_t> next = policy;
      std::vector<std::size_t> here;
      for (std::size_t s = 0; s < next.size(); ++s) {
        if (cell_[s] == conflict.cell && fixed_[s] == kFree) {
          here.push_back(s);
          fixed_[s] = action;
          next[s] = action;
        }
      }
      if (optimum(next) > most_ + kRounding * scale_of(most_)) {
        branch(next);
      }
      for (const std::size_t s : here) {
        fixed_[s] = kFree;
      }
    }
  }

  const Chain& chain_;
  double gamma_;
  std::uint64_t effort_;
  const std::function<bool()>& go_on_;
  std::size_t stride_;
  std::vector<double> rewards_;
  std::vector<std::vector<std::uint8_t>> splits_;
  PolicyValue value_;
  std::vector<std::uint8_t> fixed_;  // [states], an action or kFree
  std::vector<std::uint32_t> cell_;  // [states], of the set in question
  std::vector<double> advantages_;
  std::vector<double> weights_;  // [cells x (actions + 1)]
  std::vector<std::uint8_t> root_;
  double most_ = 0.0;
  std::uint64_t solved_ = 0;
  bool spent_ = false;
  bool interrupted_ = false;
};

}  // namespace

bool SizeBound::tree_is_best() const { return closed && most <= tree + 1e-7 * scale_of(tree); }

Result<SizeBound> bound_of_size(const Chain& chain, const Tree& tree, double gamma, std::uint64_t effort,
                                const std::function<bool()>& go_on) {
  if (chain.states() > kMaxSolvedStates) {
    return bad_input(fmt::format("{} states: expected {} at most", chain.states(), kMaxSolvedStates));
  }
  SizeSearch search(chain, gamma, effort, go_on);
  SizeBound bound;
  bound.gamma = gamma;
  bound.conditions = condition_count(tree.nodes());
  ChainActions actions = actions_of_policy(chain);
  const auto of_policy = search.return_of(actions);
  const auto of_tree = search.return_of(actions_of(chain, tree));
  const double of_any = search.optimum(actions);
  if (!of_policy || !of_tree || !std::isfinite(of_any)) {
    return bad_input(fmt::format("the chain cannot be solved with a discount of {}", gamma));
  }
  bound.policy = *of_policy;
  bound.tree = *of_tree;
  bound.any_policy = of_any;
  bound.most = of_any;
  const std::size_t splits = search.splits().size();
  bound.sets = sets_of(splits, std::min(splits, bound.conditions));
  if (bound.sets <= static_cast<double>(effort) && bound.conditions < 16) {
    if (const auto most = search.most(bound.conditions, actions, bound.tree)) {
      bound.closed = true;
      bound.most = *most;
    }
  }
  bound.solved = search.solved();
  if (search.interrupted()) {
    return interrupted();
  }
  return bound;
}

}  // namespace coppice
