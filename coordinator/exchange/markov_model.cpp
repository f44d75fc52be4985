#include "coordinator/exchange/markov_model.hpp"

#include <algorithm>
#include <cmath>

#include "common/tree/action_table.hpp"
#include "common/tree/state_columns.hpp"

namespace coppice {
namespace {

constexpr std::string_view kHold = "hold";
constexpr std::string_view kLeave = "leave";
constexpr std::string_view kEnd = "end";
constexpr std::string_view kStart = "start";
constexpr std::string_view kStay = "stay";
enum FixedLabel : std::size_t { kInitLabel = 0, kTerminalLabel, kUnknownLabel, kStartLabel, kFirstOfUser };

// Wilson, "Probable inference, the law of succession, and statistical inference", JASA 1927.
void fill_interval(double count, double tries, ModelTarget& target) {
  constexpr double kNormal95 = 1.959963984540054;  // the 97.5 % quantile of the standard normal distribution
  constexpr double kSquare = kNormal95 * kNormal95;
  const double p = count / tries;
  const double centre = p + kSquare / (2.0 * tries);
  const double margin = kNormal95 * std::sqrt(p * (1.0 - p) / tries + kSquare / (4.0 * tries * tries));
  const double scale = 1.0 + kSquare / tries;
  target.low = std::min(p, std::max(0.0, (centre - margin) / scale));
  target.high = std::max(p, std::min(1.0, (centre + margin) / scale));
}

// The largest entry takes what rounding left, until the sum in this order is 1.
void settle(std::vector<ModelTarget>& targets) {
  const auto largest = std::max_element(targets.begin(), targets.end(), [](const ModelTarget& a, const ModelTarget& b) {
    return a.probability < b.probability;
  });
  constexpr int kRounds = 4;
  for (int round = 0; round < kRounds; ++round) {
    double sum = 0.0;
    for (const ModelTarget& target : targets) {
      sum += target.probability;
    }
    if (sum == 1.0) {
      return;
    }
    largest->probability += 1.0 - sum;
  }
}

ModelChoice& next_choice(std::vector<ModelChoice>& choices, std::size_t& used, std::string_view action) {
  if (used == choices.size()) {
    choices.emplace_back();
  }
  ModelChoice& choice = choices[used++];
  choice.action = action;
  choice.targets.clear();
  choice.gain = 0.0;
  choice.cost = 0.0;
  return choice;
}

void add_sure(std::uint32_t to, std::string_view action, std::vector<ModelChoice>& choices, std::size_t& used) {
  next_choice(choices, used, action).targets.push_back({to, 1.0, 1.0, 1.0});
}

}  // namespace

MarkovModel::MarkovModel(const Chain& chain, const Tree* tree, std::vector<StateLabel> labels)
    : chain_(chain),
      unknown_(static_cast<std::uint32_t>(chain.states())),
      labels_(std::move(labels)),
      label_names_{"init", "terminal", "unknown", "start"} {
  if (chain.starts().size() > 1) {
    start_ = unknown_ + 1;
  }
  for (const StateLabel& label : labels_) {
    label_names_.push_back(label.name);
  }
  if (tree != nullptr) {
    actions_.resize(chain.states());
    fill_action_table(*tree, StateColumns(chain.vocabulary(), chain.parts().features),
                      static_cast<std::uint8_t>(chain.actions()), actions_);
    for (std::size_t state = 0; state < actions_.size(); ++state) {
      actions_[state] = static_cast<std::uint8_t>(chain.taken(state, actions_[state]));
    }
  }
  std::vector<ModelChoice> choices_here;
  for (std::size_t state = 0; state < states(); ++state) {
    choices_of(state, choices_here);
    choices_ += choices_here.size();
    for (const ModelChoice& choice : choices_here) {
      transitions_ += choice.targets.size();
    }
  }
}

std::vector<std::size_t> MarkovModel::labels_of(std::size_t state) const {
  std::vector<std::size_t> result;
  if (state == initial()) {
    result.push_back(kInitLabel);
  }
  if (state < unknown_ && chain_.is_terminal(state)) {
    result.push_back(kTerminalLabel);
  }
  if (state == unknown_) {
    result.push_back(kUnknownLabel);
  }
  if (start_ && state == *start_) {
    result.push_back(kStartLabel);
  }
  for (std::size_t i = 0; i < labels_.size(); ++i) {
    if (state < unknown_ && labels_[i].holds[state]) {
      result.push_back(kFirstOfUser + i);
    }
  }
  return result;
}

void MarkovModel::add_row(std::size_t row, std::string_view action, std::vector<ModelChoice>& choices,
                          std::size_t& used) const {
  const auto successors = chain_.successors(row);
  const auto counts = chain_.counts(row);
  if (successors.empty()) {
    add_sure(unknown_, kLeave, choices, used);
    return;
  }
  ModelChoice& choice = next_choice(choices, used, action);
  const auto tries = static_cast<double>(chain_.tries(row));
  for (std::size_t i = 0; i < successors.size(); ++i) {
    const auto count = static_cast<double>(counts[i]);
    ModelTarget& target = choice.targets.emplace_back();
    target.state = successors[i];
    target.probability = count / tries;
    fill_interval(count, tries, target);
  }
  settle(choice.targets);
  const double reward = chain_.mean_reward(row);
  choice.gain = std::max(reward, 0.0);
  choice.cost = std::max(-reward, 0.0);
}

void MarkovModel::choices_of(std::size_t state, std::vector<ModelChoice>& choices) const {
  std::size_t used = 0;
  if (state == unknown_) {
    add_sure(unknown_, kStay, choices, used);
  } else if (start_ && state == *start_) {
    ModelChoice& choice = next_choice(choices, used, kStart);
    for (const StartShare& start : chain_.starts()) {
      const double p = static_cast<double>(start.count) / static_cast<double>(chain_.starts_total());
      choice.targets.push_back({start.state, p, p, p});
    }
    settle(choice.targets);
  } else if (chain_.is_terminal(state)) {
    add_row(state * chain_.actions(), kEnd, choices, used);
    for (ModelTarget& target : choices.front().targets) {  // given, not counted
      target.low = target.high = target.probability;
    }
  } else if (is_mdp()) {
    for (std::size_t action = 0; action < chain_.actions(); ++action) {
      const std::size_t row = state * chain_.actions() + action;
      if (chain_.tries(row) > 0) {
        add_row(row, chain_.vocabulary().actions[action], choices, used);
      }
    }
    if (used == 0) {
      add_sure(unknown_, kLeave, choices, used);
    }
  } else if (actions_[state] < chain_.actions()) {
    add_row(state * chain_.actions() + actions_[state], chain_.vocabulary().actions[actions_[state]], choices, used);
  } else {
    add_sure(static_cast<std::uint32_t>(state), kHold, choices, used);
  }
  choices.resize(used);
}

}  // namespace coppice
