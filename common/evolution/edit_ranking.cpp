#include "common/evolution/edit_ranking.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/check.hpp"
#include "common/evolution/edit_candidate.hpp"
#include "common/evolution/edit_pairs.hpp"
#include "common/evolution/edit_places.hpp"
#include "common/evolution/edit_shortlist.hpp"
#include "common/evolution/edit_sums.hpp"
#include "common/tree/tree_size.hpp"

namespace coppice {
namespace {

constexpr double kNegligible = 1e-9;  // of a gain, beside the largest of any state

// Those whose gains are not negligible beside the largest.
std::vector<std::uint32_t> states_that_matter(std::span<const double> gains, std::size_t stride) {
  double largest = 0.0;
  for (const double gain : gains) {
    largest = std::max(largest, std::abs(gain));
  }
  std::vector<std::uint32_t> states;
  for (std::size_t s = 0; s * stride < gains.size(); ++s) {
    const auto row = gains.subspan(s * stride, stride);
    if (std::any_of(row.begin(), row.end(), [&](double gain) { return std::abs(gain) > kNegligible * largest; })) {
      states.push_back(static_cast<std::uint32_t>(s));
    }
  }
  return states;
}

}  // namespace

// All edits of one tree.
class EditRanking::Pass {
 public:
  Pass(const EditRanking& ranking, const Tree& tree, std::span<const double> gains, const EditLimits& limits,
       std::size_t count)
      : chain_(ranking.chain_),
        tree_(tree),
        gains_(gains),
        limits_(limits),
        actions_(chain_.actions()),
        states_(states_that_matter(gains, actions_ + 1)),
        places_(chain_, tree, states_),
        sums_(chain_, *ranking.slots_, gains, states_),
        shortlist_(tree, limits, count) {
    for (std::size_t node = 0; node < tree.size(); ++node) {
      only_asks_.push_back(action_count(tree.subtree(node)) == 0);
    }
    for (std::size_t m = 0; m < states_.size(); ++m) {
      base_ += gains_[states_[m] * (actions_ + 1) + places_.now(m)];
    }
  }

  std::vector<RankedEdit> single(std::size_t count) {
    for (std::size_t node = 0; node < tree_.size(); ++node) {
      rank_node(node);
      if (tree_[node].is_composite()) {
        for (std::size_t gap = 0; gap <= places_.children(node).size(); ++gap) {
          rank_gap(node, gap);
        }
        rank_swaps(node);
      }
    }
    return shortlist_.made(count);
  }

  std::vector<RankedEdit> twofold(std::size_t count) {
    const auto rank = [&](const EditCandidate& place, std::ptrdiff_t conditions, PairForms forms) {
      rank_pairs(sums_, {.place = place, .base = base_, .conditions = conditions, .forms = forms}, actions_,
                 shortlist_);
    };
    for (std::size_t node = 0; node < tree_.size(); ++node) {
      if (!(limits_.guarded && only_asks_[node]) &&
          sums_.take_up(places_, [&](std::size_t m) { return places_.at_node(node, m); })) {
        EditCandidate place;
        place.node = node;
        place.nodes = -static_cast<std::ptrdiff_t>(tree_[node].extent);
        const std::size_t parent = places_.parent(node);
        const bool in_selector = parent != kNowhere && places_.is_selector(parent);
        rank(place, -static_cast<std::ptrdiff_t>(condition_count(tree_.subtree(node))),
             {.branch = parent == kNowhere || in_selector,
              .list = !in_selector || places_.children(parent).back() == node});
      }
      for (std::size_t gap = 0; places_.is_selector(node) && gap <= places_.children(node).size(); ++gap) {
        if (!(limits_.guarded && only_asks_[node]) &&
            sums_.take_up(places_, [&](std::size_t m) { return places_.at_gap(node, gap, m); })) {
          EditCandidate place;
          place.node = node;
          place.gap = gap;
          rank(place, 0, {.branch = true, .list = false});
        }
      }
    }
    return shortlist_.made(count);
  }

 private:
  // The action, other than `but`, that gains most where a condition holds, or where it does not; kNowhere: there is
  // none.
  std::size_t best_where(const double* where, std::size_t but) const {
    return best_action(but, [&](std::size_t a) { return where[kWrites + a]; });
  }
  std::size_t best_elsewhere(const double* where, std::size_t but) const {
    return best_action(but, [&](std::size_t a) { return sums_.total()[kWrites + a] - where[kWrites + a]; });
  }
  template <typename GainOf>
  std::size_t best_action(std::size_t but, const GainOf& gain_of) const {
    std::size_t best = kNowhere;
    for (std::size_t a = 0; a < actions_; ++a) {
      if (a != but && (best == kNowhere || gain_of(a) > gain_of(best))) {
        best = a;
      }
    }
    return best;
  }

  void rank_node(std::size_t node) {
    if (!sums_.take_up(places_, [&](std::size_t m) { return places_.at_node(node, m); })) {
      return;
    }
    const Node& old = tree_[node];
    const auto removed = static_cast<std::ptrdiff_t>(old.extent);
    const auto tests = static_cast<std::ptrdiff_t>(condition_count(tree_.subtree(node)));
    const bool in_selector = places_.parent(node) != kNowhere && places_.is_selector(places_.parent(node));
    const bool in_sequence = places_.parent(node) != kNowhere && !places_.is_selector(places_.parent(node));
    const auto replace = [&](EditForm form, double gain, std::ptrdiff_t nodes, std::ptrdiff_t conditions) {
      EditCandidate candidate;
      candidate.gain = base_ + gain;
      candidate.nodes = nodes - removed;
      candidate.form = form;
      candidate.node = node;
      return std::pair{candidate, conditions - tests};
    };
    const bool is_condition = old.kind == NodeKind::condition;
    const bool for_conditions_only = limits_.guarded && only_asks_[node];
    if (places_.parent(node) != kNowhere && places_.children(places_.parent(node)).size() > 1) {
      const auto [candidate, conditions] =
          replace(EditForm::remove, in_selector ? sums_.total()[kFails] : sums_.total()[kSucceeds], 0, 0);
      if (!(limits_.guarded && in_sequence && !only_asks_[node])) {
        offer(candidate, conditions);
      }
    }
    for (std::size_t a = 0; a < actions_ && !for_conditions_only; ++a) {
      if (!(old.kind == NodeKind::action && old.index == a)) {
        auto [candidate, conditions] = replace(EditForm::action, sums_.total()[kWrites + a], 1, 0);
        candidate.action = static_cast<std::uint8_t>(a);
        offer(candidate, conditions);
      }
    }
    sums_.for_conditions([&](const Node& condition, const double* where) {
      const auto put = [&](EditForm form, double gain, std::ptrdiff_t nodes, std::ptrdiff_t more, std::size_t action,
                           std::size_t second) {
        auto [candidate, conditions] = replace(form, gain, nodes, more);
        candidate.condition = condition;
        candidate.action = static_cast<std::uint8_t>(action);
        candidate.second = static_cast<std::uint8_t>(second);
        offer(candidate, conditions);
      };
      const double fails = sums_.total()[kFails] - where[kFails];
      if ((!limits_.guarded || only_asks_[node]) && !(is_condition && old == condition)) {
        put(EditForm::condition, where[kSucceeds] + fails, 1, 1, 0, 0);
      }
      if (for_conditions_only) {
        return;
      }
      if (!in_sequence && removed > 1) {
        for (std::size_t a = 0; a < actions_; ++a) {
          put(EditForm::branch, where[kWrites + a] + fails, 3, 1, a, 0);
        }
      }
      if (!limits_.guarded && !in_selector) {
        const std::size_t a = best_elsewhere(where, kNowhere);
        put(EditForm::unless, where[kSucceeds] + sums_.total()[kWrites + a] - where[kWrites + a], 3, 1, a, 0);
      }
      if (!in_selector) {
        const std::size_t first = best_where(where, kNowhere);
        const std::size_t second = best_elsewhere(where, first);
        const auto choose = [&](std::size_t x, std::size_t y) {
          if (x != kNowhere && y != kNowhere && x != y) {
            put(EditForm::choice, where[kWrites + x] + sums_.total()[kWrites + y] - where[kWrites + y], 5, 1, x, y);
          }
        };
        choose(first, second);
        choose(best_where(where, second), second);
        if (old.kind == NodeKind::action) {
          choose(old.index, best_elsewhere(where, old.index));
          choose(best_where(where, old.index), old.index);
        }
      }
      if (!in_sequence && old.kind != NodeKind::sequence) {
        put(EditForm::guard, fails, removed + 2, 1 + tests, 0, 0);
      }
      if (!in_selector && old.kind != NodeKind::selector) {
        for (std::size_t a = 0; a < actions_; ++a) {
          put(EditForm::precede, where[kWrites + a], removed + 4, 1 + tests, a, 0);
        }
      }
    });
  }

  void rank_gap(std::size_t parent, std::size_t gap) {
    const std::vector<std::size_t>& children = places_.children(parent);
    const bool selector = places_.is_selector(parent);
    // Behind what always succeeds nothing is reached; take_up() finds that out. In a guarded sequence: before what
    // acts.
    const bool for_condition = !limits_.guarded || only_asks_[parent] ||
                               (!selector && gap < children.size() &&
                                std::all_of(children.begin(), children.begin() + static_cast<std::ptrdiff_t>(gap),
                                            [&](std::size_t c) { return only_asks_[c]; }));
    const bool for_branch = !limits_.guarded || (selector && !only_asks_[parent]);
    if ((!for_condition && !for_branch) ||
        !sums_.take_up(places_, [&](std::size_t m) { return places_.at_gap(parent, gap, m); })) {
      return;
    }
    const auto put = [&](EditForm form, double gain, std::ptrdiff_t nodes, std::ptrdiff_t more, const Node& condition,
                         std::size_t action) {
      EditCandidate candidate;
      candidate.gain = base_ + gain;
      candidate.nodes = nodes;
      candidate.form = form;
      candidate.node = parent;
      candidate.gap = gap;
      candidate.condition = condition;
      candidate.action = static_cast<std::uint8_t>(action);
      offer(candidate, more);
    };
    for (std::size_t a = 0; a < actions_ && for_branch; ++a) {
      put(EditForm::action, sums_.total()[kWrites + a], 1, 0, Node{}, a);
    }
    sums_.for_conditions([&](const Node& condition, const double* where) {
      const double fails = sums_.total()[kFails] - where[kFails];
      if (for_condition) {
        put(EditForm::condition, where[kSucceeds] + fails, 1, 1, condition, 0);
      }
      if (!for_branch) {
        return;
      }
      for (std::size_t a = 0; a < actions_; ++a) {
        if (selector) {
          put(EditForm::branch, where[kWrites + a] + fails, 3, 1, condition, a);
        } else {
          put(EditForm::unless, where[kSucceeds] + sums_.total()[kWrites + a] - where[kWrites + a], 3, 1, condition, a);
        }
      }
    });
  }

  void rank_swaps(std::size_t parent) {
    const std::vector<std::size_t>& children = places_.children(parent);
    if (limits_.guarded && !places_.is_selector(parent)) {
      return;
    }
    for (std::size_t a = 0; a < children.size(); ++a) {
      for (std::size_t b = a + 1; b < children.size(); ++b) {
        if (tree_[children[a]].kind == NodeKind::condition && tree_[children[b]].kind == NodeKind::condition) {
          continue;
        }
        EditCandidate candidate;
        candidate.form = EditForm::swap;
        candidate.node = parent;
        candidate.gap = a;
        candidate.other = b;
        candidate.gain = gain_swapped(parent, a, b);
        offer(candidate, 0);
      }
    }
  }

  double gain_swapped(std::size_t parent, std::size_t a, std::size_t b) const {
    double gain = 0.0;
    for (std::size_t m = 0; m < states_.size(); ++m) {
      gain += gains_[states_[m] * (actions_ + 1) + places_.swapped(parent, a, b, m)];
    }
    return gain;
  }

  void offer(const EditCandidate& candidate, std::ptrdiff_t conditions) { shortlist_.offer(candidate, conditions); }

  const Chain& chain_;
  const Tree& tree_;
  std::span<const double> gains_;
  EditLimits limits_;
  std::size_t actions_;
  std::vector<std::uint32_t> states_;
  EditPlaces places_;
  EditSums sums_;
  double base_ = 0.0;  // what the tree itself gains
  EditShortlist shortlist_;
  std::vector<bool> only_asks_;  // [nodes], no action below it
};

EditRanking::EditRanking(const Chain& chain) : chain_(chain), slots_(std::make_unique<ValueSlots>(chain)) {}
EditRanking::~EditRanking() = default;

std::vector<RankedEdit> EditRanking::best(const Tree& tree, std::span<const double> gains, const EditLimits& limits,
                                          std::size_t count) {
  COPPICE_CHECK(gains.size() == chain_.states() * (chain_.actions() + 1) && count >= 1);
  return Pass(*this, tree, gains, limits, count).single(count);
}

std::vector<RankedEdit> EditRanking::best_of_two_conditions(const Tree& tree, std::span<const double> gains,
                                                            const EditLimits& limits, std::size_t count) {
  COPPICE_CHECK(gains.size() == chain_.states() * (chain_.actions() + 1) && count >= 1);
  return Pass(*this, tree, gains, limits, count).twofold(count);
}

double EditRanking::gain_of(std::span<const std::uint8_t> actions, std::span<const double> gains) const {
  COPPICE_CHECK(actions.size() == chain_.states());
  double sum = 0.0;
  for (std::size_t s = 0; s < actions.size(); ++s) {
    sum += gains[s * (chain_.actions() + 1) + actions[s]];
  }
  return sum;
}

}  // namespace coppice
