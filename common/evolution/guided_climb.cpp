#include "common/evolution/guided_climb.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <utility>

#include "common/chain/exact.hpp"
#include "common/check.hpp"
#include "common/tree/action_table.hpp"
#include "common/tree/tree_size.hpp"

namespace coppice {
namespace {

constexpr std::size_t kTries = 12;          // edits that are solved before a tree counts as a local optimum
constexpr double kLeastGain = 1e-9;         // of the worth, relative: less is rounding
constexpr double kLeastFirstOrder = 1e-12;  // the same of what an edit promises
constexpr double kSmallestWorth = 1e-6;     // to which the two above are relative at least
constexpr std::size_t kFirstOfPair = 3;     // edits of each kind that a pair begins with, at least
constexpr std::size_t kNodesOfPairs = 240;  // about so many nodes are ranked again: smaller trees have more such edits

}  // namespace

Result<std::unique_ptr<GuidedClimb>> GuidedClimb::make(const Chain& chain, const Job& job) {
  if (chain.states() > kMaxSolvedStates) {
    return bad_input(fmt::format("{} states: guided edits solve at most {}; expected ga.guided = 0", chain.states(),
                                 kMaxSolvedStates));
  }
  std::vector<Table> tables;
  for (const Objective& objective : job.objectives) {
    const auto table = make_score_table(chain, objective);
    if (!table) {
      return tl::unexpected(table.error());
    }
    tables.push_back({along_walk(objective.kind), {}});
    tables.back().scores.assign(table->scores.begin(), table->scores.end());
  }
  const double gamma =
      job.method == Method::discounted ? fixed_point_value(job.gamma) : std::min(1.0 - 1.0 / job.steps, kMaxGamma);
  return std::unique_ptr<GuidedClimb>(new GuidedClimb(chain, gamma, std::move(tables)));
}

GuidedClimb::GuidedClimb(const Chain& chain, double gamma, std::vector<Table> tables)
    : chain_(chain),
      gamma_(gamma),
      tables_(std::move(tables)),
      columns_(chain.vocabulary(), chain.parts().features),
      ranking_(chain),
      now_(std::make_unique<PolicyValue>(chain)),
      next_(std::make_unique<PolicyValue>(chain)),
      actions_(chain.states()),
      tried_(chain.states()) {}

// The worth of every (state, action), a step of the walk and once.
void GuidedClimb::weigh(std::span<const double> worth) {
  COPPICE_CHECK(worth.size() == tables_.size());
  const std::size_t size = chain_.states() * (chain_.actions() + 1);
  walk_.assign(size, 0.0);
  states_.assign(size, 0.0);
  walks_ = false;
  for (std::size_t o = 0; o < tables_.size(); ++o) {
    if (worth[o] == 0.0) {
      continue;
    }
    walks_ = walks_ || tables_[o].along_walk;
    std::vector<double>& sum = tables_[o].along_walk ? walk_ : states_;
    for (std::size_t i = 0; i < size; ++i) {
      sum[i] += worth[o] * tables_[o].scores[i];
    }
  }
}

void GuidedClimb::fill(const Tree& tree, std::vector<std::uint8_t>& actions) const {
  fill_action_table(tree, columns_, static_cast<std::uint8_t>(chain_.actions()), actions);
}

// False: it cannot be solved.
bool GuidedClimb::evaluate(PolicyValue& value, std::span<const std::uint8_t> actions, double& worth) {
  worth = ranking_.gain_of(actions, states_);
  if (walks_) {
    ++solved_;
    if (!value.solve(actions, walk_, gamma_)) {
      return false;
    }
    worth += (1.0 - gamma_) * value.expected_return();
  }
  return true;
}

void GuidedClimb::find_gains() {
  const std::size_t stride = chain_.actions() + 1;
  if (walks_) {
    now_->advantages(walk_, advantages_);
  }
  gains_.resize(states_.size());
  for (std::size_t s = 0; s < chain_.states(); ++s) {
    const double here = states_[s * stride + actions_[s]];
    for (std::size_t a = 0; a < stride; ++a) {
      gains_[s * stride + a] = states_[s * stride + a] - here;
      // What is done now gains nothing, whatever rounding says.
      if (walks_ && a != actions_[s]) {
        gains_[s * stride + a] += now_->occupancy()[s] * advantages_[s * stride + a];
      }
    }
  }
}

// The best of two edits in a row, by first order.
std::vector<RankedEdit> GuidedClimb::pairs(const Tree& tree, const EditLimits& limits) {
  const std::size_t count = std::max(kFirstOfPair, kNodesOfPairs / tree.size());
  std::vector<RankedEdit> first = ranking_.best(tree, gains_, limits, count);
  if (const std::size_t conditions = condition_count(tree.nodes()); conditions > 0) {
    EditLimits smaller = limits;
    smaller.max_conditions = conditions - 1;
    for (RankedEdit& edit : ranking_.best(tree, gains_, smaller, count)) {
      first.push_back(std::move(edit));
    }
  }
  std::vector<RankedEdit> second;
  for (const RankedEdit& edit : first) {
    for (RankedEdit& both : ranking_.best(edit.tree, gains_, limits, kTries)) {
      second.push_back(std::move(both));
    }
  }
  std::stable_sort(second.begin(), second.end(),
                   [](const RankedEdit& a, const RankedEdit& b) { return a.gain > b.gain; });
  second.resize(std::min(second.size(), kTries));
  return second;
}

// Takes the first of these that improves, if any does.
bool GuidedClimb::step_up(std::vector<RankedEdit> edits, Tree& tree, double& reached) {
  const double scale = std::max(std::abs(reached), kSmallestWorth);
  for (RankedEdit& edit : edits) {
    if (edit.gain <= kLeastFirstOrder * scale) {
      break;
    }
    fill(edit.tree, tried_);
    double tried = 0.0;
    if (known_.insert(meaning_of(tried_)).second && evaluate(*next_, tried_, tried) &&
        tried > reached + kLeastGain * scale) {
      tree = std::move(edit.tree);
      reached = tried;
      std::swap(now_, next_);
      std::swap(actions_, tried_);
      return true;
    }
  }
  return false;
}

Tree GuidedClimb::climb(const Tree& start, std::span<const double> worth, const EditLimits& limits,
                        const Effort& effort) {
  weigh(worth);
  known_.clear();
  Tree tree = start;
  fill(tree, actions_);
  known_.insert(meaning_of(actions_));
  double reached = 0.0;
  if (!evaluate(*now_, actions_, reached)) {
    return tree;
  }
  for (std::uint32_t step = 0; step < effort.steps; ++step) {
    find_gains();
    if (!step_up(ranking_.best(tree, gains_, limits, kTries), tree, reached) &&
        !(effort.pairs && step_up(pairs(tree, limits), tree, reached))) {
      break;
    }
  }
  return tree;
}

}  // namespace coppice
