#include "common/chain/policy_value.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/chain/exact.hpp"
#include "common/check.hpp"

namespace coppice {

PolicyValue::PolicyValue(const Chain& chain) : chain_(chain) { COPPICE_CHECK(chain.states() <= kMaxSolvedStates); }

void PolicyValue::fill_columns(std::span<const std::uint8_t> actions) {
  const std::size_t states = chain_.states();
  columns_.begin.assign(1, 0);
  columns_.row.clear();
  columns_.value.clear();
  uniform_.assign(states, 0.0);
  for (std::size_t s = 0; s < states; ++s) {
    const std::size_t at = columns_.row.size();
    columns_.row.push_back(static_cast<int>(s));
    columns_.value.push_back(1.0);
    const std::size_t taken = chain_.taken(s, actions[s]);
    if (taken == chain_.actions()) {
      columns_.value[at] -= gamma_;
    } else {
      const std::size_t row = s * chain_.actions() + taken;
      if (chain_.tries(row) == 0) {
        uniform_[s] = 1.0;
      }
      const auto tries = static_cast<double>(chain_.tries(row));
      const auto successors = chain_.successors(row);
      const auto counts = chain_.counts(row);
      for (std::size_t i = 0; i < successors.size(); ++i) {
        const double entry = gamma_ * (static_cast<double>(counts[i]) / tries);
        if (successors[i] == s) {
          columns_.value[at] -= entry;
        } else {
          columns_.row.push_back(static_cast<int>(successors[i]));
          columns_.value.push_back(-entry);
        }
      }
    }
    columns_.begin.push_back(static_cast<int>(columns_.row.size()));
  }
}

// The states that a walk from the start comes to. False: it takes an action that was never tried, and may go anywhere.
bool PolicyValue::find_walked(std::span<const std::uint8_t> actions) {
  place_.assign(chain_.states(), -1);
  walked_.clear();
  const auto come_to = [&](std::uint32_t state) {
    if (place_[state] < 0) {
      place_[state] = 0;
      walked_.push_back(state);
    }
  };
  for (const StartShare& start : chain_.starts()) {
    come_to(start.state);
  }
  for (std::size_t i = 0; i < walked_.size(); ++i) {
    const std::uint32_t s = walked_[i];
    const std::size_t taken = chain_.taken(s, actions[s]);
    if (taken == chain_.actions()) {
      continue;
    }
    const std::size_t row = s * chain_.actions() + taken;
    if (chain_.tries(row) == 0) {
      return false;
    }
    for (const std::uint32_t successor : chain_.successors(row)) {
      come_to(successor);
    }
  }
  std::sort(walked_.begin(), walked_.end());
  for (std::size_t i = 0; i < walked_.size(); ++i) {
    place_[walked_[i]] = static_cast<std::int32_t>(i);
  }
  return true;
}

// As fill_columns(), of the states in walked_ alone. All their actions were tried.
void PolicyValue::fill_walked_columns(std::span<const std::uint8_t> actions) {
  columns_.begin.assign(1, 0);
  columns_.row.clear();
  columns_.value.clear();
  for (const std::uint32_t s : walked_) {
    const std::size_t at = columns_.row.size();
    columns_.row.push_back(place_[s]);
    columns_.value.push_back(1.0);
    const std::size_t taken = chain_.taken(s, actions[s]);
    if (taken == chain_.actions()) {
      columns_.value[at] -= gamma_;
    } else {
      const std::size_t row = s * chain_.actions() + taken;
      const auto tries = static_cast<double>(chain_.tries(row));
      const auto successors = chain_.successors(row);
      const auto counts = chain_.counts(row);
      for (std::size_t i = 0; i < successors.size(); ++i) {
        const double entry = gamma_ * (static_cast<double>(counts[i]) / tries);
        if (successors[i] == s) {
          columns_.value[at] -= entry;
        } else {
          columns_.row.push_back(place_[successors[i]]);
          columns_.value.push_back(-entry);
        }
      }
    }
    columns_.begin.push_back(static_cast<int>(columns_.row.size()));
  }
}

std::optional<double> PolicyValue::return_of(std::span<const std::uint8_t> actions, std::span<const double> rewards,
                                             double gamma, const PolicyValue* alike) {
  const std::size_t stride = chain_.actions() + 1;
  COPPICE_CHECK(actions.size() == chain_.states() && rewards.size() == chain_.states() * stride && gamma >= 0.0 &&
                gamma <= kMaxGamma && alike != this);
  if (!find_walked(actions)) {
    return solve(actions, rewards, gamma) ? std::optional(return_) : std::nullopt;
  }
  gamma_ = gamma;
  fill_walked_columns(actions);
  whole_ = false;
  const bool same_states = alike != nullptr && alike->whole_ && walked_.size() == chain_.states();
  if (!(same_states ? lu_.factorise_alike(columns_, alike->lu_) : lu_.factorise(columns_))) {
    return std::nullopt;
  }
  values_.resize(walked_.size());
  for (std::size_t i = 0; i < walked_.size(); ++i) {
    values_[i] = rewards[walked_[i] * stride + actions[walked_[i]]];
  }
  lu_.solve_transposed(values_);
  const auto starts = static_cast<double>(chain_.starts_total());
  double sum = 0.0;
  for (const StartShare& start : chain_.starts()) {
    sum += static_cast<double>(start.count) / starts * values_[static_cast<std::size_t>(place_[start.state])];
  }
  return std::isfinite(sum) ? std::optional(sum) : std::nullopt;
}

bool PolicyValue::solve(std::span<const std::uint8_t> actions, std::span<const double> rewards, double gamma) {
  const std::size_t states = chain_.states();
  const std::size_t stride = chain_.actions() + 1;
  COPPICE_CHECK(actions.size() == states && rewards.size() == states * stride && gamma >= 0.0 && gamma <= kMaxGamma);
  gamma_ = gamma;
  fill_columns(actions);
  whole_ = lu_.factorise(columns_);
  if (!whole_) {
    return false;
  }
  values_.resize(states);
  for (std::size_t s = 0; s < states; ++s) {
    values_[s] = rewards[s * stride + actions[s]];
  }
  lu_.solve_transposed(values_);
  occupancy_.assign(states, 0.0);
  const auto starts = static_cast<double>(chain_.starts_total());
  for (const StartShare& start : chain_.starts()) {
    occupancy_[start.state] = (1.0 - gamma) * (static_cast<double>(start.count) / starts);
  }
  lu_.solve(occupancy_);
  // A = B - (gamma / S) 1 u^T for d, and its transpose for V, with u the uniform shares: one correction serves both.
  const auto all = static_cast<double>(states);
  if (std::any_of(uniform_.begin(), uniform_.end(), [](double share) { return share > 0.0; })) {
    std::vector<double> spread(states, gamma / all);  // B^-1 (gamma / S) 1
    lu_.solve(spread);
    const double rest = 1.0 - std::inner_product(uniform_.begin(), uniform_.end(), spread.begin(), 0.0);
    if (!(rest > 0.0)) {
      return false;
    }
    std::vector<double> drawn = uniform_;  // B^-T u
    lu_.solve_transposed(drawn);
    const double value = gamma / all * std::accumulate(values_.begin(), values_.end(), 0.0) / rest;
    const double mass = std::inner_product(uniform_.begin(), uniform_.end(), occupancy_.begin(), 0.0) / rest;
    for (std::size_t s = 0; s < states; ++s) {
      values_[s] += value * drawn[s];
      occupancy_[s] += mass * spread[s];
    }
  }
  mean_value_ = std::accumulate(values_.begin(), values_.end(), 0.0) / all;
  return_ = 0.0;
  for (const StartShare& start : chain_.starts()) {
    return_ += static_cast<double>(start.count) / starts * values_[start.state];
  }
  return std::isfinite(return_) && std::isfinite(mean_value_);
}

double PolicyValue::next_value(std::size_t state, std::size_t chosen) const {
  const std::size_t action = chain_.taken(state, chosen);
  if (action == chain_.actions()) {
    return values_[state];
  }
  const std::size_t row = state * chain_.actions() + action;
  if (chain_.tries(row) == 0) {
    return mean_value_;
  }
  const auto successors = chain_.successors(row);
  const auto counts = chain_.counts(row);
  double sum = 0.0;
  for (std::size_t i = 0; i < successors.size(); ++i) {
    sum += static_cast<double>(counts[i]) * values_[successors[i]];
  }
  return sum / static_cast<double>(chain_.tries(row));
}

void PolicyValue::advantages(std::span<const double> rewards, std::vector<double>& result) const {
  const std::size_t stride = chain_.actions() + 1;
  COPPICE_CHECK(rewards.size() == chain_.states() * stride);
  result.resize(rewards.size());
  for (std::size_t s = 0; s < chain_.states(); ++s) {
    for (std::size_t a = 0; a < stride; ++a) {
      result[s * stride + a] = rewards[s * stride + a] + gamma_ * next_value(s, a) - values_[s];
    }
  }
}

}  // namespace coppice
