#include "common/chain/exact_rows.hpp"

#include <algorithm>

#include "common/check.hpp"

namespace coppice {
namespace {

constexpr std::uint32_t kUnknown = 0xFFFFFFFF;

}  // namespace

ReachedRows::ReachedRows(const Chain& chain) : chain_(chain), numbers_(chain.states(), kUnknown) {}

void ReachedRows::set_probabilities(std::span<const double> probabilities) {
  COPPICE_CHECK(probabilities.empty() || probabilities.size() == chain_.transitions());
  probabilities_ = probabilities;
}

void ReachedRows::begin(const ActingTables& acting) {
  COPPICE_CHECK(acting.actions.size() == chain_.states());
  COPPICE_CHECK(acting.others_share == 0.0 || acting.others.size() == chain_.states());
  acting_ = acting;
  for (const std::uint32_t state : states_) {
    numbers_[state] = kUnknown;
  }
  states_.clear();
  begin_.assign(1, 0);
  transitions_.clear();
  uniform_.clear();
  for (const StartShare& start : chain_.starts()) {
    number_of(start.state);
  }
}

std::vector<double> ReachedRows::start() const {
  std::vector<double> shares;
  shares.reserve(chain_.starts().size());
  for (const StartShare& start : chain_.starts()) {
    shares.push_back(static_cast<double>(start.count) / static_cast<double>(chain_.starts_total()));
  }
  return shares;
}

std::uint32_t ReachedRows::number_of(std::uint32_t state) {
  if (numbers_[state] == kUnknown) {
    numbers_[state] = static_cast<std::uint32_t>(states_.size());
    states_.push_back(state);
  }
  return numbers_[state];
}

void ReachedRows::discover_all() {
  for (std::uint32_t state = 0; state < chain_.states() && states_.size() < chain_.states(); ++state) {
    number_of(state);
  }
}

void ReachedRows::add(std::uint32_t to, double probability) { transitions_.push_back({to, probability}); }

void ReachedRows::add_action(std::uint32_t state, std::size_t action, double share) {
  if (share == 0.0) {
    return;
  }
  if (action == chain_.actions()) {
    add(number_of(state), share);
    return;
  }
  const std::size_t row = std::size_t{state} * chain_.actions() + action;
  const auto tries = static_cast<double>(chain_.tries(row));
  if (chain_.tries(row) == 0) {
    uniform_.back() += share;
    return;
  }
  const auto successors = chain_.successors(row);
  const auto counts = chain_.counts(row);
  if (!probabilities_.empty()) {
    const auto of_row = probabilities_.subspan(chain_.parts().row_begin[row], successors.size());
    for (std::size_t i = 0; i < successors.size(); ++i) {
      add(number_of(successors[i]), share * of_row[i]);
    }
    return;
  }
  for (std::size_t i = 0; i < successors.size(); ++i) {
    add(number_of(successors[i]), share * (static_cast<double>(counts[i]) / tries));
  }
}

void ReachedRows::expand(std::size_t rows) {
  COPPICE_CHECK(rows <= states_.size());
  while (uniform_.size() < rows) {
    const std::uint32_t state = states_[uniform_.size()];
    uniform_.push_back(0.0);
    const std::size_t action = chain_.taken(state, acting_.actions[state]);
    const std::size_t other = acting_.others_share == 0.0 ? action : chain_.taken(state, acting_.others[state]);
    if (other == action) {
      add_action(state, action, 1.0);
    } else {
      add_action(state, action, 1.0 - acting_.others_share);
      add_action(state, other, acting_.others_share);
      // The two actions may share successors: one transition each.
      const auto first = transitions_.begin() + static_cast<std::ptrdiff_t>(begin_.back());
      std::sort(first, transitions_.end(), [](const Transition& a, const Transition& b) {
        return a.to != b.to ? a.to < b.to : a.probability < b.probability;
      });
      auto kept = first;
      for (auto next = first; next != transitions_.end(); ++next) {
        if (kept != first && (kept - 1)->to == next->to) {
          (kept - 1)->probability += next->probability;
        } else {
          *kept++ = *next;
        }
      }
      transitions_.erase(kept, transitions_.end());
    }
    begin_.push_back(transitions_.size());
  }
}

void ReachedRows::expand_all() {
  while (uniform_.size() < states_.size()) {
    expand(uniform_.size() + 1);
    if (uniform_.back() > 0.0) {
      discover_all();
    }
  }
}

}  // namespace coppice
