#include "common/chain/exact_events.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/chain/exact.hpp"
#include "common/check.hpp"

namespace coppice {
namespace {

constexpr std::uint32_t kOutside = 0xFFFFFFFF;

std::vector<double> by_number(std::span<const double> of_state, const std::vector<std::uint32_t>& states) {
  std::vector<double> result;
  result.reserve(states.size());
  for (const std::uint32_t state : states) {
    result.push_back(of_state[state]);
  }
  return result;
}

}  // namespace

void ExactEvents::begin(const ActingTables& acting, std::span<const double> probabilities) {
  COPPICE_CHECK(acting.others_share == 0.0);
  rows_.set_probabilities(probabilities);
  rows_.begin(acting);
  for (std::size_t made = 0; made < rows_.size(); ++made) {  // ends: every state is discovered once
    rows_.expand(made + 1);
  }
}

double ExactEvents::within(std::span<const double> chance, std::uint32_t steps) {
  const std::vector<double> event = by_number(chance, rows_.states());
  now_ = rows_.start();
  now_.resize(rows_.size(), 0.0);
  double met = 0.0;
  for (std::uint32_t step = 0; step < steps; ++step) {
    next_.assign(rows_.size(), 0.0);
    for (std::size_t k = 0; k < now_.size(); ++k) {
      if (now_[k] == 0.0) {
        continue;
      }
      met += now_[k] * event[k];
      const double on = now_[k] * (1.0 - event[k]);
      for (const auto& [to, probability] : rows_.row(k)) {
        next_[to] += on * probability;
      }
    }
    now_.swap(next_);
  }
  return met;
}

// The states that the walk can be in while the event has not happened. [reached]
std::vector<bool> ExactEvents::before_event(const std::vector<double>& chance) const {
  std::vector<bool> alive(rows_.size(), false);
  std::vector<std::uint32_t> open(rows_.chain().starts().size());
  std::iota(open.begin(), open.end(), 0U);
  std::fill_n(alive.begin(), open.size(), true);
  while (!open.empty()) {  // ends: every state is opened once
    const std::uint32_t k = open.back();
    open.pop_back();
    if (chance[k] >= 1.0) {
      continue;
    }
    for (const auto& [to, probability] : rows_.row(k)) {
      if (!alive[to] && probability > 0.0) {
        alive[to] = true;
        open.push_back(to);
      }
    }
  }
  return alive;
}

std::vector<bool> ExactEvents::leading_to_event(const std::vector<double>& chance,
                                                const std::vector<bool>& alive) const {
  std::vector<std::vector<std::uint32_t>> from(rows_.size());
  std::vector<bool> leads(rows_.size(), false);
  std::vector<std::uint32_t> open;
  for (std::uint32_t k = 0; k < rows_.size(); ++k) {
    if (!alive[k]) {
      continue;
    }
    if (chance[k] > 0.0) {
      leads[k] = true;
      open.push_back(k);
    }
    if (chance[k] < 1.0) {
      for (const auto& [to, probability] : rows_.row(k)) {
        if (probability > 0.0) {
          from[to].push_back(k);
        }
      }
    }
  }
  while (!open.empty()) {  // ends: every state is opened once
    const std::uint32_t k = open.back();
    open.pop_back();
    for (const std::uint32_t before : from[k]) {
      if (!leads[before]) {
        leads[before] = true;
        open.push_back(before);
      }
    }
  }
  return leads;
}

std::optional<FirstEvent> ExactEvents::ever(std::span<const double> chance_of_state) {
  COPPICE_CHECK(rows_.chain().states() <= kMaxSolvedStates);
  const std::vector<double> chance = by_number(chance_of_state, rows_.states());
  const std::vector<bool> alive = before_event(chance);
  const std::vector<bool> leads = leading_to_event(chance, alive);
  const std::vector<double> start = rows_.start();
  if (std::none_of(leads.begin(), leads.begin() + static_cast<std::ptrdiff_t>(start.size()),
                   [](bool leads_there) { return leads_there; })) {
    return FirstEvent{};
  }
  std::vector<std::uint32_t> number(rows_.size(), kOutside);
  std::vector<std::uint32_t> inside;
  bool certain = true;
  for (std::uint32_t k = 0; k < rows_.size(); ++k) {
    if (leads[k]) {
      number[k] = static_cast<std::uint32_t>(inside.size());
      inside.push_back(k);
      certain = certain && (chance[k] >= 1.0 || rows_.uniform(k) == 0.0);
    } else {
      certain = certain && !alive[k];
    }
  }
  columns_.begin.assign(1, 0);
  columns_.row.clear();
  columns_.value.clear();
  std::vector<double> lost(inside.size(), 0.0);  // probability of ending without the event
  for (std::uint32_t j = 0; j < inside.size(); ++j) {
    const std::uint32_t k = inside[j];
    const double on = 1.0 - chance[k];
    // 1 - B(k, k), as a sum of what is positive: nothing cancels.
    double diagonal = chance[k] + on * rows_.uniform(k);
    lost[j] = on * rows_.uniform(k);
    const std::size_t at = columns_.row.size();
    columns_.row.push_back(static_cast<int>(j));
    columns_.value.push_back(0.0);
    for (const auto& [to, probability] : rows_.row(k)) {
      if (to != k) {
        diagonal += on * probability;
        if (number[to] == kOutside) {
          lost[j] += on * probability;
        } else if (on * probability > 0.0) {
          columns_.row.push_back(static_cast<int>(number[to]));
          columns_.value.push_back(-on * probability);
        }
      }
    }
    columns_.value[at] = diagonal;
    columns_.begin.push_back(static_cast<int>(columns_.row.size()));
    if (static_cast<double>(columns_.row.size()) > kMaxFactorEntries) {
      return std::nullopt;
    }
  }
  if (!lu_.factorise(columns_)) {
    return std::nullopt;
  }
  std::vector<double> visits(inside.size(), 0.0);
  double without = 0.0;
  for (std::size_t k = 0; k < start.size(); ++k) {
    if (number[k] == kOutside) {
      without += start[k];
    } else {
      visits[number[k]] = start[k];
    }
  }
  lu_.solve(visits);
  std::vector<double> weighted = visits;
  lu_.solve(weighted);
  FirstEvent result;
  for (std::size_t j = 0; j < inside.size(); ++j) {
    result.probability += visits[j] * chance[inside[j]];
    result.steps += weighted[j] * chance[inside[j]];
    without += visits[j] * lost[j];
  }
  if (!(std::abs(result.probability + without - 1.0) <= kSolveTolerance)) {
    return std::nullopt;
  }
  if (result.probability == 0.0) {  // below the smallest double
    return FirstEvent{};
  }
  result.steps /= result.probability;
  result.probability = certain ? 1.0 : std::min(result.probability, 1.0);
  return result;
}

}  // namespace coppice
