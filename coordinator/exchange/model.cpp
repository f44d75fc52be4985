#include "coordinator/exchange/model.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "common/chain/chain.hpp"

namespace coppice {
namespace {

bool ascending(const std::vector<std::uint32_t>& values) {
  return std::adjacent_find(values.begin(), values.end(), std::greater_equal<>()) == values.end();
}

}  // namespace

bool Model::is_terminal(std::uint32_t state) const {
  return std::binary_search(terminals.begin(), terminals.end(), state);
}

Result<void> ModelRows::add(std::uint32_t state, std::uint32_t action, double reward_of_row,
                            std::vector<ModelTransition>& row) {
  if (!std::isfinite(reward_of_row)) {
    return bad_input(fmt::format("state {}: reward {} is not finite", state, reward_of_row));
  }
  std::sort(row.begin(), row.end(), [](const ModelTransition& a, const ModelTransition& b) {
    return a.successor != b.successor ? a.successor < b.successor : a.probability < b.probability;
  });
  rows_.push_back({state, action, reward_of_row, transitions_.size()});
  double sum = 0.0;
  for (const ModelTransition& transition : row) {
    if (!(transition.probability >= 0.0 && transition.probability <= 1.0 + kRowTolerance)) {
      return bad_input(fmt::format("state {}: probability {} of going to state {}: expected 0 to 1", state,
                                   transition.probability, transition.successor));
    }
    if (transition.probability == 0.0) {
      continue;
    }
    sum += transition.probability;
    const bool repeats =
        transitions_.size() > rows_.back().begin && transitions_.back().successor == transition.successor;
    if (repeats) {
      transitions_.back().probability += transition.probability;
    } else {
      transitions_.push_back(transition);
    }
  }
  if (!(std::abs(sum - 1.0) <= kRowTolerance)) {
    return bad_input(fmt::format("state {}: the probabilities of a choice sum to {}: expected 1", state, sum));
  }
  for (std::uint64_t i = rows_.back().begin; i < transitions_.size(); ++i) {
    transitions_[i].probability /= sum;
  }
  return {};
}

Result<void> ModelRows::fill(std::size_t states, std::size_t actions, Model& model) {
  constexpr std::uint64_t kNoRow = ~std::uint64_t{0};
  if (states * actions > kMaxModelRows) {
    return bad_input(
        fmt::format("{} states with {} actions: expected a product of at most {}", states, actions, kMaxModelRows));
  }
  std::vector<std::uint64_t> place(states * actions, kNoRow);
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const Row& row = rows_[i];
    if (row.state >= states || row.action >= actions) {
      return bad_input(fmt::format("a choice of state {}, action {}: expected a state below {} and an action below {}",
                                   row.state, row.action, states, actions));
    }
    std::uint64_t& at = place[row.state * actions + row.action];
    if (at != kNoRow) {
      return bad_input(fmt::format("state {} has action {} twice", row.state, row.action));
    }
    at = i;
  }
  model.row_begin.assign(1, 0);
  model.row_begin.reserve(place.size() + 1);
  model.reward.assign(place.size(), 0.0);
  model.successor.clear();
  model.probability.clear();
  model.successor.reserve(transitions_.size());
  model.probability.reserve(transitions_.size());
  for (std::size_t row = 0; row < place.size(); ++row) {
    if (place[row] != kNoRow) {
      const Row& source = rows_[place[row]];
      const std::uint64_t end = place[row] + 1 < rows_.size() ? rows_[place[row] + 1].begin : transitions_.size();
      for (std::uint64_t i = source.begin; i < end; ++i) {
        if (transitions_[i].successor >= states) {
          return bad_input(fmt::format("state {} leads to state {}: expected below {}", source.state,
                                       transitions_[i].successor, states));
        }
        model.successor.push_back(transitions_[i].successor);
        model.probability.push_back(transitions_[i].probability);
      }
      model.reward[row] = source.reward;
    }
    model.row_begin.push_back(model.successor.size());
  }
  return {};
}

Result<void> check_model(const Model& model) {
  const std::size_t states = model.states();
  if (states == 0 || states > kMaxStates) {
    return bad_input(fmt::format("{} states: expected 1 to {}", states, kMaxStates));
  }
  if (model.feature_names.size() > kMaxModelFeatures) {
    return bad_input(fmt::format("{} features: expected at most {}", model.feature_names.size(), kMaxModelFeatures));
  }
  if (model.action_names.empty() || model.action_names.size() > kMaxActions) {
    return bad_input(fmt::format("{} actions: expected 1 to {}", model.action_names.size(), kMaxActions));
  }
  const std::size_t rows = states * model.actions();
  if (model.rows() != rows || model.reward.size() != rows || model.successor.size() != model.probability.size() ||
      model.row_begin.back() != model.successor.size() ||
      (!model.collision.empty() && model.collision.size() != rows)) {
    return bad_input(fmt::format("{} rows for {} states and {} actions", model.rows(), states, model.actions()));
  }
  if (std::any_of(model.readings.begin(), model.readings.end(), [](double r) { return !std::isfinite(r); })) {
    return bad_input("a feature reads what is not a finite number");
  }
  double sum = 0.0;
  for (std::size_t i = 0; i < model.starts.size(); ++i) {
    const ModelStart& start = model.starts[i];
    if (start.state >= states || !(start.probability > 0.0) || (i > 0 && start.state <= model.starts[i - 1].state)) {
      return bad_input(
          fmt::format("start {} is state {} with probability {}: expected ascending states below {}, with "
                      "probabilities above 0",
                      i, start.state, start.probability, states));
    }
    sum += start.probability;
  }
  if (!(std::abs(sum - 1.0) <= kRowTolerance)) {
    return bad_input(model.starts.empty()
                         ? "no state where episodes start: expected a label init, \"initial\" in the tables, "
                           "or initial in a problem file"
                         : fmt::format("the probabilities of the starts sum to {}: expected 1", sum));
  }
  if (!ascending(model.terminals) || (!model.terminals.empty() && model.terminals.back() >= states)) {
    return bad_input(fmt::format("terminal states are not ascending, or not below {}", states));
  }
  return {};
}

void find_sinks(Model& model) {
  for (std::uint32_t state = 0; state < model.states(); ++state) {
    bool stays = true;
    for (std::size_t row = state * model.actions(); row < (state + std::size_t{1}) * model.actions() && stays; ++row) {
      for (std::uint64_t i = model.row_begin[row]; i < model.row_begin[row + 1]; ++i) {
        stays = stays && model.successor[i] == state;
      }
      stays = stays && model.reward[row] == 0.0;
    }
    if (stays && !model.is_terminal(state)) {
      model.terminals.insert(std::lower_bound(model.terminals.begin(), model.terminals.end(), state), state);
    }
  }
}

std::size_t keep_reachable(Model& model) {
  constexpr std::uint32_t kGone = 0xFFFFFFFF;
  const std::size_t states = model.states();
  std::vector<bool> reached(states, false);
  std::vector<std::uint32_t> open;
  const auto reach = [&](std::uint32_t state) {
    if (!reached[state]) {
      reached[state] = true;
      open.push_back(state);
    }
  };
  for (const ModelStart& start : model.starts) {
    reach(start.state);
  }
  while (!open.empty()) {  // ends: every state is opened once
    const std::uint32_t state = open.back();
    open.pop_back();
    if (model.is_terminal(state)) {
      continue;
    }
    for (std::uint64_t i = model.row_begin[state * model.actions()];
         i < model.row_begin[(state + std::size_t{1}) * model.actions()]; ++i) {
      reach(model.successor[i]);
    }
  }
  std::vector<std::uint32_t> number(states, kGone);
  std::vector<std::uint32_t> kept;
  for (std::uint32_t state = 0; state < states; ++state) {
    if (reached[state]) {
      number[state] = static_cast<std::uint32_t>(kept.size());
      kept.push_back(state);
    }
  }
  if (kept.size() == states) {
    return 0;
  }
  Model result;
  result.feature_names = model.feature_names;
  result.action_names = model.action_names;
  result.row_begin.assign(1, 0);
  for (const std::uint32_t state : kept) {
    const auto readings = model.readings_of(state);
    result.readings.insert(result.readings.end(), readings.begin(), readings.end());
    result.source_state.push_back(model.source_of(state));
    for (std::size_t row = state * model.actions(); row < (state + std::size_t{1}) * model.actions(); ++row) {
      // A terminal state's row may lead to what is gone; it does not matter.
      const bool ends = model.is_terminal(state);
      for (std::uint64_t i = model.row_begin[row]; i < model.row_begin[row + 1] && !ends; ++i) {
        result.successor.push_back(number[model.successor[i]]);
        result.probability.push_back(model.probability[i]);
      }
      result.row_begin.push_back(result.successor.size());
      result.reward.push_back(ends ? 0.0 : model.reward[row]);
      if (!model.collision.empty()) {
        result.collision.push_back(ends ? 0.0 : model.collision[row]);
      }
    }
  }
  const auto renumber = [&](const std::vector<std::uint32_t>& from) {
    std::vector<std::uint32_t> to;
    for (const std::uint32_t state : from) {
      if (number[state] != kGone) {
        to.push_back(number[state]);
      }
    }
    return to;
  };
  result.terminals = renumber(model.terminals);
  for (const ModelStart& start : model.starts) {
    result.starts.push_back({number[start.state], start.probability});
  }
  for (const auto& [label, labelled] : model.labels) {
    result.labels[label] = renumber(labelled);
  }
  model = std::move(result);
  return states - kept.size();
}

Result<void> drop_actions(const std::vector<std::string>& names, Model& model) {
  std::vector<bool> dropped(model.actions(), false);
  for (const std::string& name : names) {
    const auto found = std::find(model.action_names.begin(), model.action_names.end(), name);
    if (found == model.action_names.end()) {
      return bad_input(
          fmt::format("no action '{}' to leave out: expected one of {}", name, fmt::join(model.action_names, ", ")));
    }
    dropped[static_cast<std::size_t>(found - model.action_names.begin())] = true;
  }
  Model kept = model;
  kept.action_names.clear();
  kept.row_begin.assign(1, 0);
  kept.successor.clear();
  kept.probability.clear();
  kept.reward.clear();
  kept.collision.clear();
  for (std::size_t action = 0; action < model.actions(); ++action) {
    if (!dropped[action]) {
      kept.action_names.push_back(model.action_names[action]);
    }
  }
  if (kept.action_names.empty()) {
    return bad_input("no action is left: expected to leave out fewer");
  }
  for (std::size_t row = 0; row < model.rows(); ++row) {
    if (dropped[row % model.actions()]) {
      continue;
    }
    for (std::uint64_t i = model.row_begin[row]; i < model.row_begin[row + 1]; ++i) {
      kept.successor.push_back(model.successor[i]);
      kept.probability.push_back(model.probability[i]);
    }
    kept.row_begin.push_back(kept.successor.size());
    kept.reward.push_back(model.reward[row]);
    if (!model.collision.empty()) {
      kept.collision.push_back(model.collision[row]);
    }
  }
  model = std::move(kept);
  return {};
}

}  // namespace coppice
