#include "common/evolution/guided_climb.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
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

// Forgets what was tried under other weights.
void GuidedClimb::begin(std::span<const double> worth) {
  weigh(worth);
  known_.clear();
  passed_.clear();
}

// Nothing: it cannot be solved.
std::optional<double> GuidedClimb::worth_of(std::span<const std::uint8_t> actions) {
  double worth = ranking_.gain_of(actions, states_);
  if (walks_) {
    ++solved_;
    const auto walk = next_->return_of(actions, walk_, gamma_, solved_now_ ? now_.get() : nullptr);
    if (!walk) {
      return std::nullopt;
    }
    worth += (1.0 - gamma_) * *walk;
  }
  return worth;
}

// Makes the tree what gains are measured against. Nothing: it cannot be solved.
std::optional<double> GuidedClimb::stand_on(const Tree& tree) {
  fill(tree, actions_);
  double worth = ranking_.gain_of(actions_, states_);
  if (walks_) {
    ++solved_;
    solved_now_ = now_->solve(actions_, walk_, gamma_);
    if (!solved_now_) {
      return std::nullopt;
    }
    worth += (1.0 - gamma_) * now_->expected_return();
  }
  find_gains();
  const Meaning meaning = meaning_of(actions_);
  known_.emplace(meaning, worth);
  passed_.insert(meaning);
  return worth;
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
bool GuidedClimb::step_up(std::vector<RankedEdit> edits, Reached& reached, std::size_t tries) {
  const double scale = std::max(std::abs(reached.worth), kSmallestWorth);
  for (RankedEdit& edit : edits) {
    if (edit.gain <= kLeastFirstOrder * scale || tries == 0) {
      break;
    }
    --tries;
    fill(edit.tree, tried_);
    const Meaning meaning = meaning_of(tried_);
    auto known = known_.find(meaning);
    if (known == known_.end()) {
      const auto worth = worth_of(tried_);
      known = known_.emplace(meaning, worth ? *worth : std::numeric_limits<double>::lowest()).first;
    }
    if (known->second > reached.worth + kLeastGain * scale) {
      reached = {std::move(edit.tree), known->second};
      return true;
    }
  }
  return false;
}

// REQUIRES: stand_on(reached.tree) came last.
void GuidedClimb::ascend(Reached& reached, const EditLimits& limits, const Ascent& ascent) {
  for (std::uint32_t step = 0; step < ascent.steps; ++step) {
    if (!step_up(ranking_.best(reached.tree, gains_, limits, ascent.tries), reached, ascent.tries) &&
        !(ascent.pairs && step_up(pairs(reached.tree, limits), reached, kTries)) &&
        !(ascent.pairs &&
          step_up(ranking_.best_of_two_conditions(reached.tree, gains_, limits, kTries), reached, kTries))) {
      return;
    }
    fill(reached.tree, actions_);
    const bool been_here = passed_.count(meaning_of(actions_)) > 0;
    if ((ascent.merges && been_here) || !stand_on(reached.tree)) {
      return;
    }
  }
}

Tree GuidedClimb::climb(const Tree& start, std::span<const double> worth, const EditLimits& limits,
                        const Effort& effort) {
  begin(worth);
  Reached reached{start, 0.0};
  const auto at_start = stand_on(start);
  if (!at_start) {
    return start;
  }
  reached.worth = *at_start;
  ascend(reached, limits, {.steps = effort.steps, .tries = kTries, .pairs = effort.pairs, .merges = false});
  const std::uint64_t until = solved_ + effort.leaps;
  while (effort.leaps > 0 && solved_ < until && leap(reached, limits, until)) {
  }
  return reached.tree;
}

}  // namespace coppice
