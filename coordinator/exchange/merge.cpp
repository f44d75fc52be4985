#include <algorithm>
#include <map>

#include "coordinator/exchange/chain_of_model.hpp"

namespace coppice {
namespace {

constexpr double kLeastWeight = 1e-12;  // of a state that is never visited, beside those that are

// The number of each state after the merge, in the order of the first of each kind.
std::vector<std::uint32_t> numbers_of(const Model& model, std::uint32_t& states) {
  std::map<std::pair<bool, std::vector<double>>, std::uint32_t> known;
  std::vector<std::uint32_t> numbers;
  for (std::uint32_t state = 0; state < model.states(); ++state) {
    const auto readings = model.readings_of(state);
    const auto [found, added] =
        known.emplace(std::pair{model.is_terminal(state), std::vector<double>(readings.begin(), readings.end())},
                      static_cast<std::uint32_t>(known.size()));
    numbers.push_back(found->second);
  }
  states = static_cast<std::uint32_t>(known.size());
  return numbers;
}

}  // namespace

Merged merge_look_alikes(const Model& model, const PolicyOfModel& policy) {
  Merged merged;
  std::uint32_t states = 0;
  merged.state_of = numbers_of(model, states);
  const std::size_t actions = model.actions();
  Model& result = merged.model;
  result.feature_names = model.feature_names;
  result.action_names = model.action_names;
  result.readings.resize(states * model.feature_names.size());
  merged.policy.q.assign(states * actions, 0.0);
  merged.policy.weight.assign(states, 0.0);
  merged.policy.policy.assign(states, ActionId{0});
  result.reward.assign(states * actions, 0.0);
  result.collision.assign(model.collision.empty() ? 0 : states * actions, 0.0);
  std::vector<double> row_weight(states * actions, 0.0);
  std::vector<double> q_weight(states, 0.0);
  std::vector<double> votes(states * actions, 0.0);
  std::vector<std::map<std::uint32_t, double>> rows(states * actions);
  double largest = 0.0;
  for (const double weight : policy.weight) {
    largest = std::max(largest, weight);
  }
  for (std::size_t state = 0; state < model.states(); ++state) {
    const std::uint32_t to = merged.state_of[state];
    const double weight = std::max(policy.weight[state], kLeastWeight * std::max(largest, 1.0));
    const auto readings = model.readings_of(state);
    std::copy(readings.begin(), readings.end(),
              result.readings.begin() + static_cast<std::ptrdiff_t>(to * readings.size()));
    merged.policy.weight[to] += policy.weight[state];
    votes[to * actions + index_of(policy.policy[state])] += weight;
    q_weight[to] += weight;
    for (std::size_t action = 0; action < actions; ++action) {
      const std::size_t from_row = state * actions + action;
      const std::size_t to_row = to * actions + action;
      merged.policy.q[to_row] += weight * policy.q[from_row];
      if (model.row_begin[from_row] == model.row_begin[from_row + 1]) {
        continue;
      }
      row_weight[to_row] += weight;
      result.reward[to_row] += weight * model.reward[from_row];
      if (!model.collision.empty()) {
        result.collision[to_row] += weight * model.collision[from_row];
      }
      for (std::uint64_t i = model.row_begin[from_row]; i < model.row_begin[from_row + 1]; ++i) {
        rows[to_row][merged.state_of[model.successor[i]]] += weight * model.probability[i];
      }
    }
  }
  result.row_begin.assign(1, 0);
  for (std::size_t row = 0; row < rows.size(); ++row) {
    for (const auto& [successor, weight] : rows[row]) {
      result.successor.push_back(successor);
      result.probability.push_back(weight / row_weight[row]);
    }
    result.row_begin.push_back(result.successor.size());
    if (row_weight[row] > 0.0) {
      result.reward[row] /= row_weight[row];
      if (!result.collision.empty()) {
        result.collision[row] /= row_weight[row];
      }
    }
    merged.policy.q[row] /= q_weight[row / actions];
  }
  for (std::size_t state = 0; state < states; ++state) {
    const auto begin = votes.begin() + static_cast<std::ptrdiff_t>(state * actions);
    merged.policy.policy[state] = ActionId{
        static_cast<std::uint8_t>(std::max_element(begin, begin + static_cast<std::ptrdiff_t>(actions)) - begin)};
  }
  std::map<std::uint32_t, double> starts;
  for (const ModelStart& start : model.starts) {
    starts[merged.state_of[start.state]] += start.probability;
  }
  for (const auto& [state, probability] : starts) {
    result.starts.push_back({state, probability});
  }
  for (const std::uint32_t state : model.terminals) {
    result.terminals.push_back(merged.state_of[state]);
  }
  std::sort(result.terminals.begin(), result.terminals.end());
  result.terminals.erase(std::unique(result.terminals.begin(), result.terminals.end()), result.terminals.end());
  return merged;
}

}  // namespace coppice
