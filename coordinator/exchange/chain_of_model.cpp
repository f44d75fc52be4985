#include "coordinator/exchange/chain_of_model.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numeric>
#include <optional>

#include "common/check.hpp"
#include "coordinator/exchange/binning.hpp"
#include "coordinator/exchange/counting.hpp"
#include "coordinator/exchange/feature_scale.hpp"
#include "coordinator/exchange/predicate.hpp"

namespace coppice {
namespace {

constexpr double kVisitsInAll = 1e9;  // what shares of visits become, as whole numbers

// [states], whether chosen. Errors name the place.
Result<std::vector<bool>> chosen_states(const std::string& place, const StateChoice& choice, const Model& model) {
  std::vector<bool> chosen(model.states(), false);
  if (!choice.label.empty()) {
    const auto found = model.labels.find(choice.label);
    if (found == model.labels.end()) {
      std::vector<std::string> names;
      names.reserve(model.labels.size());
      for (const auto& [name, states] : model.labels) {
        names.push_back(name);
      }
      return bad_input(fmt::format("{}.label: no label '{}' in the source: expected one of ({})", place, choice.label,
                                   fmt::join(names, ", ")));
    }
    for (const std::uint32_t state : found->second) {
      chosen[state] = true;
    }
  }
  if (!choice.when.empty()) {
    const auto predicate = Predicate::parse(choice.when, model.feature_names);
    if (!predicate) {
      return in_context(place + ".when", predicate.error());
    }
    for (std::size_t state = 0; state < model.states(); ++state) {
      chosen[state] = predicate->holds(model.readings_of(state));
    }
  }
  for (const auto& [source, share] : choice.shares) {
    bool found = false;
    for (std::uint32_t state = 0; state < model.states(); ++state) {
      const bool same = model.source_of(state) == source;
      chosen[state] = chosen[state] || same;
      found = found || same;
    }
    if (!found) {
      return bad_input(fmt::format("{}.shares: state {} is not in the source", place, source));
    }
  }
  if (std::none_of(chosen.begin(), chosen.end(), [](bool is) { return is; })) {
    return bad_input(fmt::format("{}: no state fits", place));
  }
  return chosen;
}

// The distinct readings of a feature, and its edges where it needs some.
struct FeatureColumn {
  DistinctReadings distinct;
  std::vector<ClassedReading> classed;  // of the states that decide, weighted by visits
};

FeatureColumn column_of(const Model& model, const PolicyOfModel& policy, std::size_t feature) {
  FeatureColumn column;
  double sum = 0.0;
  for (const double weight : policy.weight) {
    sum += weight;
  }
  for (std::size_t state = 0; state < model.states(); ++state) {
    const double reading = model.readings_of(state)[feature];
    column.distinct.add(reading);
    if (!model.is_terminal(static_cast<std::uint32_t>(state))) {
      // Every state counts a little, so that bins do not forget what the policy avoids.
      const double share = (sum > 0.0 ? policy.weight[state] / sum : 0.0) + 1.0 / static_cast<double>(model.states());
      column.classed.push_back({reading, static_cast<std::uint8_t>(index_of(policy.policy[state])), share});
    }
  }
  return column;
}

struct Encoding {
  std::vector<Feature> features;
  std::vector<std::uint8_t> values;  // [states x features]
};

Result<std::vector<double>> edges_for(const Binning& binning, const std::vector<ClassedReading>& classed) {
  switch (binning.kind) {
    case Binning::Kind::edges:
      return given_edges(binning.edges);
    case Binning::Kind::quantiles:
      return quantile_edges(classed, binning.bins);
    case Binning::Kind::entropy:
      return entropy_edges(classed, binning.bins, true);
    case Binning::Kind::none:
      break;
  }
  return std::vector<double>();
}

std::vector<FeatureWish> wishes_of(const ProblemFile& file, const std::vector<std::string>& names) {
  std::vector<FeatureWish> wishes;
  for (const std::string& name : names) {
    const auto found = file.features.find(name);
    wishes.push_back(found == file.features.end() ? FeatureWish{} : found->second);
  }
  return wishes;
}

Result<void> check_wishes(const ProblemFile& file, const Model& model) {
  const auto listed = [](const std::vector<std::string>& names) { return fmt::format("{}", fmt::join(names, ", ")); };
  for (const auto& [name, wish] : file.features) {
    if (std::find(model.feature_names.begin(), model.feature_names.end(), name) == model.feature_names.end()) {
      return bad_input(fmt::format("features.{}: no such feature in the source: expected one of ({})", name,
                                   listed(model.feature_names)));
    }
  }
  for (const auto& [name, wish] : file.actions) {
    if (std::find(model.action_names.begin(), model.action_names.end(), name) == model.action_names.end()) {
      return bad_input(fmt::format("actions.{}: no such action in the source: expected one of ({})", name,
                                   listed(model.action_names)));
    }
  }
  return {};
}

Result<Encoding> encode(const Model& model, const PolicyOfModel& policy, const ProblemFile& file) {
  const std::vector<FeatureWish> wishes = wishes_of(file, model.feature_names);
  std::vector<std::string> names;
  names.reserve(wishes.size());
  for (std::size_t f = 0; f < wishes.size(); ++f) {
    names.push_back(wishes[f].name.empty() ? model.feature_names[f] : wishes[f].name);
  }
  names = legal_names(names, "f");
  // A source of ours that has too many readings is cut finely: where the policy changes cannot be known beforehand.
  const Binning fine{.kind = Binning::Kind::quantiles, .edges = {}, .bins = kMaxValues};
  Encoding encoding;
  for (std::size_t f = 0; f < names.size(); ++f) {
    const FeatureColumn column = column_of(model, policy, f);
    auto feature = feature_of(names[f], column.distinct, wishes[f], fine,
                              [&](const Binning& binning) { return edges_for(binning, column.classed); });
    if (!feature) {
      return tl::unexpected(feature.error());
    }
    encoding.features.push_back(std::move(*feature));
  }
  encoding.values.reserve(model.readings.size());
  for (std::size_t state = 0; state < model.states(); ++state) {
    for (std::size_t f = 0; f < names.size(); ++f) {
      const double reading = model.readings_of(state)[f];
      const auto value = encoding.features[f].value_of(reading == 0.0 ? 0.0 : reading);
      COPPICE_CHECK(value.has_value());
      encoding.values.push_back(*value);
    }
  }
  return encoding;
}

Result<NoAction> no_action_of(const ProblemFile& file, const Model& model) {
  if (file.no_action == "hold") {
    return NoAction{};
  }
  if (file.no_action == "worst") {
    return NoAction{NoAction::Kind::worst, ActionId{0}};
  }
  const auto found = std::find(model.action_names.begin(), model.action_names.end(), file.no_action);
  if (found == model.action_names.end()) {
    return bad_input(fmt::format("no_action is '{}': expected hold, worst or an action ({})", file.no_action,
                                 fmt::join(model.action_names, ", ")));
  }
  return NoAction{NoAction::Kind::named, ActionId{static_cast<std::uint8_t>(found - model.action_names.begin())}};
}

std::vector<StartShare> starts_of(const Model& model) {
  std::vector<double> probabilities;
  probabilities.reserve(model.starts.size());
  for (const ModelStart& start : model.starts) {
    probabilities.push_back(start.probability);
  }
  const std::vector<std::uint32_t> counts = counts_of(probabilities);
  std::vector<StartShare> shares;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (counts[i] > 0) {
      shares.push_back({model.starts[i].state, counts[i]});
    }
  }
  const auto divisor =
      std::accumulate(shares.begin(), shares.end(), 0U,
                      [](std::uint32_t sum, const StartShare& share) { return std::gcd(sum, share.count); });
  for (StartShare& share : shares) {
    share.count /= divisor;
  }
  return shares;
}

// The rows of the chain, and their collisions and reward sums.
void fill_rows(const Model& model, const ProblemFile& file, const std::vector<StartShare>& starts, ChainParts& parts,
               ImportReport& report) {
  const std::size_t rows = model.rows();
  parts.row_begin.assign(1, 0);
  parts.reward_sum.assign(rows, 0.0);
  parts.collisions.assign(model.collision.empty() ? 0 : rows, 0);
  std::vector<std::uint8_t> forbidden(rows, 0);
  for (std::size_t row = 0; row < rows; ++row) {
    const auto state = static_cast<std::uint32_t>(row / model.actions());
    const std::uint64_t begin = model.row_begin[row];
    const std::uint64_t size = model.row_begin[row + 1] - begin;
    if (model.is_terminal(state)) {
      if (file.terminal == WhenTerminal::absorb) {
        parts.successor.push_back(state);
        parts.count.push_back(kMostCounts);
      } else {
        for (const StartShare& start : starts) {
          parts.successor.push_back(start.state);
          parts.count.push_back(start.count);
        }
      }
    } else if (size == 0) {
      forbidden[row] = 1;
    } else {
      const auto counts = counts_of(std::span<const double>(model.probability).subspan(begin, size));
      std::uint64_t tries = 0;
      for (std::uint64_t i = 0; i < size; ++i) {
        if (counts[i] == 0) {
          ++report.lost_transitions;
          continue;
        }
        parts.successor.push_back(model.successor[begin + i]);
        parts.count.push_back(counts[i]);
        tries += counts[i];
      }
      parts.reward_sum[row] = model.reward[row] * static_cast<double>(tries);
      if (!model.collision.empty()) {
        parts.collisions[row] =
            static_cast<std::uint32_t>(std::llround(model.collision[row] * static_cast<double>(tries)));
      }
    }
    parts.row_begin.push_back(parts.successor.size());
  }
  if (std::find(forbidden.begin(), forbidden.end(), 1) != forbidden.end()) {
    parts.forbidden = std::move(forbidden);
  }
}

// The model that the chain's counts stand for.
Model counted_model(const Model& model, const ChainParts& parts) {
  Model counted = model;
  counted.row_begin = parts.row_begin;
  counted.successor = parts.successor;
  counted.probability.resize(parts.count.size());
  for (std::size_t row = 0; row < model.rows(); ++row) {
    double tries = 0.0;
    for (std::uint64_t i = parts.row_begin[row]; i < parts.row_begin[row + 1]; ++i) {
      tries += parts.count[i];
    }
    for (std::uint64_t i = parts.row_begin[row]; i < parts.row_begin[row + 1]; ++i) {
      counted.probability[i] = parts.count[i] / tries;
    }
    counted.reward[row] = tries > 0.0 ? parts.reward_sum[row] / tries : 0.0;
  }
  double total = 0.0;
  for (const StartShare& start : parts.starts) {
    total += start.count;
  }
  if (!parts.starts.empty()) {
    counted.starts.clear();
    for (const StartShare& start : parts.starts) {
      counted.starts.push_back({start.state, start.count / total});
    }
  }
  return counted;
}

Result<Problem> problem_of(const Vocabulary& vocabulary, const Model& model, const ProblemFile& file) {
  Problem problem = unlabelled(vocabulary);
  problem.title = file.title.substr(0, kMaxLabel);
  problem.simulator = file.simulator;
  problem.discount = file.discount;
  const std::vector<FeatureWish> wishes = wishes_of(file, model.feature_names);
  for (std::size_t f = 0; f < wishes.size(); ++f) {
    auto legend = legend_of(vocabulary.features[f], wishes[f]);
    if (!legend) {
      return tl::unexpected(legend.error());
    }
    problem.features[f] = std::move(*legend);
    // A name that had to change is kept as a label.
    if (problem.features[f].label.empty() && vocabulary.features[f].name != model.feature_names[f]) {
      problem.features[f].label = model.feature_names[f].substr(0, kMaxLabel);
    }
  }
  for (std::size_t a = 0; a < model.actions(); ++a) {
    const auto wish = file.actions.find(model.action_names[a]);
    const bool labelled = wish != file.actions.end() && !wish->second.label.empty();
    if (labelled) {
      problem.action_labels[a] = wish->second.label.substr(0, kMaxLabel);
    } else if (vocabulary.actions[a] != model.action_names[a]) {
      problem.action_labels[a] = model.action_names[a].substr(0, kMaxLabel);
    }
  }
  return problem;
}

std::uint64_t count_look_alikes(const ChainParts& parts) {
  const std::size_t width = parts.vocabulary.features.size();
  std::vector<std::uint32_t> order(parts.policy.size());
  std::iota(order.begin(), order.end(), 0U);
  const auto of = [&](std::uint32_t state) {
    return std::span<const std::uint8_t>(parts.features).subspan(state * width, width);
  };
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::lexicographical_compare(of(a).begin(), of(a).end(), of(b).begin(), of(b).end());
  });
  std::uint64_t same = 0;
  for (std::size_t i = 1; i < order.size(); ++i) {
    same += std::equal(of(order[i]).begin(), of(order[i]).end(), of(order[i - 1]).begin()) ? 1 : 0;
  }
  return same;
}

}  // namespace

Result<void> apply_problem(const ProblemFile& file, Model& model) {
  if (!file.without_actions.empty()) {
    if (auto ok = drop_actions(file.without_actions, model); !ok) {
      return in_context("without_actions", ok.error());
    }
    find_sinks(model);
  }
  if (!file.terminals.empty()) {
    const auto chosen = chosen_states("terminals", file.terminals, model);
    if (!chosen) {
      return tl::unexpected(chosen.error());
    }
    for (std::uint32_t state = 0; state < model.states(); ++state) {
      if ((*chosen)[state] && !model.is_terminal(state)) {
        model.terminals.insert(std::lower_bound(model.terminals.begin(), model.terminals.end(), state), state);
      }
    }
  }
  if (!file.initial.empty()) {
    const auto chosen = chosen_states("initial", file.initial, model);
    if (!chosen) {
      return tl::unexpected(chosen.error());
    }
    model.starts.clear();
    double sum = 0.0;
    for (std::uint32_t state = 0; state < model.states(); ++state) {
      if ((*chosen)[state]) {
        const auto share = file.initial.shares.find(model.source_of(state));
        model.starts.push_back({state, share == file.initial.shares.end() ? 1.0 : share->second});
        sum += model.starts.back().probability;
      }
    }
    for (ModelStart& start : model.starts) {
      start.probability /= sum;
    }
  }
  if ((file.collision_reward && model.collision.empty()) || !file.collisions.empty()) {
    model.collision.assign(model.rows(), 0.0);
    std::vector<bool> chosen(model.states(), false);
    if (!file.collisions.empty()) {
      auto states = chosen_states("collisions", file.collisions, model);
      if (!states) {
        return tl::unexpected(states.error());
      }
      chosen = std::move(*states);
    }
    for (std::size_t row = 0; row < model.rows(); ++row) {
      const bool has = model.row_begin[row + 1] > model.row_begin[row];
      if (file.collision_reward) {
        model.collision[row] = has && model.reward[row] <= *file.collision_reward ? 1.0 : 0.0;
        continue;
      }
      for (std::uint64_t i = model.row_begin[row]; i < model.row_begin[row + 1]; ++i) {
        model.collision[row] += chosen[model.successor[i]] ? model.probability[i] : 0.0;
      }
      model.collision[row] = std::min(model.collision[row], 1.0);
    }
  }
  return {};
}

Result<Imported> chain_of_model(Model model, PolicyOfModel policy, const ProblemFile& file,
                                const ModelValuation& valuation, const SolveProgress& go_on) {
  COPPICE_CHECK(policy.policy.size() == model.states() && policy.q.size() == model.rows() &&
                policy.weight.size() == model.states());
  if (auto ok = check_wishes(file, model); !ok) {
    return tl::unexpected(ok.error());
  }
  ImportReport report;
  if (valuation.known) {
    const auto value = value_of_policy(model, policy.policy, valuation.settings, go_on);
    if (!value) {
      return tl::unexpected(value.error());
    }
    report.value = *value;
  }
  if (file.look_alikes == LookAlikes::merge) {
    Merged merged = merge_look_alikes(model, policy);
    report.merged_states = model.states() - merged.model.states();
    if (valuation.known && report.merged_states > 0) {
      std::vector<ActionId> in_each(model.states());
      for (std::size_t state = 0; state < in_each.size(); ++state) {
        in_each[state] = merged.policy.policy[merged.state_of[state]];
      }
      const auto value = value_of_policy(model, in_each, valuation.settings, go_on);
      if (!value) {
        return tl::unexpected(value.error());
      }
      report.merged_value = *value;
    }
    model = std::move(merged.model);
    policy = std::move(merged.policy);
  }
  auto encoding = encode(model, policy, file);
  if (!encoding) {
    return tl::unexpected(encoding.error());
  }
  ChainParts parts;
  parts.vocabulary.features = std::move(encoding->features);
  std::vector<std::string> actions;
  for (const std::string& name : model.action_names) {
    const auto wish = file.actions.find(name);
    actions.push_back(wish == file.actions.end() || wish->second.name.empty() ? name : wish->second.name);
  }
  parts.vocabulary.actions = legal_names(actions, "a");
  parts.features = std::move(encoding->values);
  const auto no_action = no_action_of(file, model);
  if (!no_action) {
    return tl::unexpected(no_action.error());
  }
  parts.no_action = *no_action;
  const std::vector<StartShare> starts = starts_of(model);
  parts.initial_state = starts.front().state;
  if (starts.size() > 1) {
    parts.starts = starts;
  }
  fill_rows(model, file, starts, parts, report);
  parts.terminals = model.terminals;
  parts.q = std::move(policy.q);
  parts.policy = std::move(policy.policy);
  double sum = 0.0;
  for (const double weight : policy.weight) {
    sum += weight;
  }
  for (const double weight : policy.weight) {
    parts.visits.push_back(sum > 0.0 ? static_cast<std::uint64_t>(std::llround(weight / sum * kVisitsInAll)) : 0);
  }
  report.look_alikes = count_look_alikes(parts);
  parts.look_alikes = report.look_alikes > 0;
  if (valuation.known) {
    const auto value = value_of_policy(counted_model(model, parts), parts.policy, valuation.settings, go_on);
    if (!value) {
      return tl::unexpected(value.error());
    }
    report.count_error = *value - report.merged_value.value_or(*report.value);
    if (report.merged_value) {  // a merged model has values of its own
      const auto merged = value_of_policy(model, parts.policy, valuation.settings, go_on);
      if (!merged) {
        return tl::unexpected(merged.error());
      }
      report.count_error = *value - *merged;
    }
  }
  auto problem = problem_of(parts.vocabulary, model, file);
  if (!problem) {
    return tl::unexpected(problem.error());
  }
  auto chain = Chain::make(std::move(parts));
  if (!chain) {
    return tl::unexpected(chain.error());
  }
  return Imported{std::move(*chain), std::move(*problem), std::move(report)};
}

}  // namespace coppice
