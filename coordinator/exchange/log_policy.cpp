#include "coordinator/exchange/log_policy.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <utility>

#include "coordinator/exchange/chain_of_model.hpp"
#include "coordinator/exchange/given_policy.hpp"
#include "coordinator/exchange/predicate.hpp"

namespace coppice {
namespace {

// The counts as a model: terminal states have no rows yet, untried pairs none at all. Takes row_begin, successor and
// count out of `parts`, which gets them back from give_back(): a log's chain should not be in memory twice.
Model model_of_counts(ChainParts& parts, const LogNames& names, const std::vector<std::uint64_t>& tries,
                      bool with_readings) {
  Model model;
  model.action_names = names.actions;
  model.reward.resize(parts.reward_sum.size());
  for (std::size_t row = 0; row < tries.size(); ++row) {
    model.reward[row] = tries[row] > 0 ? parts.reward_sum[row] / static_cast<double>(tries[row]) : 0.0;
  }
  model.row_begin = std::move(parts.row_begin);
  model.successor = std::move(parts.successor);
  model.count = std::move(parts.count);
  model.terminals = parts.terminals;
  double total = 0.0;
  for (const StartShare& start : parts.starts) {
    total += start.count;
  }
  model.starts.push_back({parts.initial_state, 1.0});
  if (!parts.starts.empty()) {
    model.starts.clear();
    for (const StartShare& start : parts.starts) {
      model.starts.push_back({start.state, start.count / total});
    }
  }
  const std::size_t width = names.features.size();
  if (!with_readings) {
    model.feature_names = {"state"};
    model.readings.assign(parts.features.size() / width, 0.0);
    return model;
  }
  model.feature_names = names.features;
  model.readings.reserve(parts.features.size());
  for (std::size_t i = 0; i < parts.features.size(); ++i) {
    const Feature& feature = parts.vocabulary.features[i % width];
    const auto place = static_cast<std::size_t>(
        std::lower_bound(feature.values.begin(), feature.values.end(), parts.features[i]) - feature.values.begin());
    // Of a bin its upper edge, and of the last its lower one: any number in order does.
    model.readings.push_back(feature.scale == Scale::plain
                                 ? static_cast<double>(parts.features[i])
                                 : feature.numbers[std::min(place, feature.numbers.size() - 1)]);
  }
  return model;
}

void give_back(Model& model, ChainParts& parts) {
  parts.row_begin = std::move(model.row_begin);
  parts.successor = std::move(model.successor);
  parts.count = std::move(model.count);
}

// Pairs that were tried, but less often than `min_visits`; of a state in which none was tried as often, those that were
// tried less than the most. [states x actions]
std::vector<bool> distrusted_pairs(const std::vector<std::uint64_t>& tries, std::size_t actions,
                                   std::uint64_t min_visits) {
  std::vector<bool> distrusted(tries.size(), false);
  for (std::size_t first = 0; first < tries.size(); first += actions) {
    const auto begin = tries.begin() + static_cast<std::ptrdiff_t>(first);
    const std::uint64_t most = *std::max_element(begin, begin + static_cast<std::ptrdiff_t>(actions));
    for (std::size_t row = first; row < first + actions; ++row) {
      distrusted[row] = tries[row] > 0 && tries[row] < std::min(most, min_visits);
    }
  }
  return distrusted;
}

// What solving a log trusts, and should not.
void report_trust(const ImportSettings& settings, const Model& model, const Solution& solution,
                  const std::vector<std::uint64_t>& tries, ImportReport& report) {
  std::uint64_t decided = 0;
  for (std::size_t state = 0; state < solution.policy.size(); ++state) {
    const std::uint64_t tried = tries[state * model.actions() + index_of(solution.policy[state])];
    decided += tried > 0 ? 1 : 0;
    report.solved_on_one_try += tried == 1 ? 1 : 0;
  }
  report.distrusted = static_cast<std::uint64_t>(std::count(model.distrusted.begin(), model.distrusted.end(), true));
  if (report.solved_on_one_try > 0) {
    report.notes.push_back(
        fmt::format("--solve believes what was seen once: in {} of {} states the action that it chose was tried only "
                    "once, and what "
                    "happened then counts as certain.{}",
                    report.solved_on_one_try, decided,
                    settings.min_visits > 1 ? " Nothing there was tried more often."
                                            : " --min-visits N leaves out what was tried fewer than N times; without "
                                              "--solve the policy is the log's own."));
  }
  if (settings.min_visits > 1) {
    report.notes.push_back(fmt::format("Tried fewer than {} times and not taken: {} pairs of state and action.",
                                       settings.min_visits, report.distrusted));
  }
}

// What the log shows: the action tried most, ties to the lowest index.
std::vector<ActionId> most_tried(const std::vector<std::uint64_t>& tries, std::size_t actions, std::uint64_t& ties) {
  std::vector<ActionId> policy;
  policy.reserve(tries.size() / actions);
  for (std::size_t first = 0; first < tries.size(); first += actions) {
    const auto begin = tries.begin() + static_cast<std::ptrdiff_t>(first);
    const auto end = begin + static_cast<std::ptrdiff_t>(actions);
    const auto most = std::max_element(begin, end);
    ties += *most > 0 && std::count(begin, end, *most) > 1 ? 1 : 0;
    policy.push_back(ActionId{static_cast<std::uint8_t>(most - begin)});
  }
  return policy;
}

// Solved, given, or what the log shows.
Result<PolicyOfModel> policy_of_log(const ImportSettings& settings, Model& model,
                                    const std::vector<std::uint64_t>& tries, const SolveSettings& solving,
                                    const SolveProgress& go_on, ImportReport& report) {
  PolicyOfModel policy;
  if (settings.solve) {
    if (settings.min_visits > 1) {
      model.distrusted = distrusted_pairs(tries, model.actions(), settings.min_visits);
    }
    auto solution = solve(model, solving, go_on);
    if (!solution) {
      return tl::unexpected(solution.error());
    }
    report.ties = solution->ties;
    report.sweeps = solution->sweeps;
    report.bound = solution->bound;
    report_trust(settings, model, *solution, tries, report);
    return PolicyOfModel{std::move(solution->q), std::move(solution->policy), {}};
  }
  if (!settings.q.empty() || !settings.policy.empty()) {
    auto given = read_given_policy(settings.q, settings.policy, model);
    if (!given) {
      return tl::unexpected(given.error());
    }
    report.ties = given->ties;
    if (given->unlisted > 0) {
      report.notes.push_back(
          fmt::format("The table does not have {} of the states; the first action tried is taken "
                      "there.",
                      given->unlisted));
    }
    policy.policy = std::move(given->policy);
    policy.q = std::move(given->q);
  } else {
    policy.policy = most_tried(tries, model.actions(), report.ties);
  }
  if (policy.q.empty()) {
    const auto values = values_of_policy(model, policy.policy, solving, go_on);
    if (!values) {
      return tl::unexpected(values.error());
    }
    policy.q = q_of_values(model, *values, solving.gamma);
  }
  for (double& q : policy.q) {
    q = std::isnan(q) ? 0.0 : q;
  }
  return policy;
}

// A step that arrives where the problem file's test holds is a collision.
Result<void> collide_by_test(const std::string& when, const Model& model, ChainParts& parts) {
  if (when.empty()) {
    return {};
  }
  const auto predicate = Predicate::parse(when, model.feature_names);
  if (!predicate) {
    return in_context("collisions.when", predicate.error());
  }
  parts.collisions.assign(model.rows(), 0);
  for (std::size_t row = 0; row < model.rows(); ++row) {
    for (std::uint64_t i = model.row_begin[row]; i < model.row_begin[row + 1]; ++i) {
      parts.collisions[row] += predicate->holds(model.readings_of(model.successor[i])) ? model.count[i] : 0;
    }
  }
  return {};
}

}  // namespace

Result<void> value_log(const ImportSettings& settings, const ProblemFile& file, const LogNames& names,
                       const SolveSettings& solving, const std::vector<std::uint64_t>& tries,
                       const ImportProgress& go_on, ChainParts& parts, ImportReport& report) {
  const auto during = [&go_on](std::string_view what) -> SolveProgress {
    return go_on ? SolveProgress([&go_on, what](double share) { return go_on(what, share); }) : SolveProgress();
  };
  const bool with_readings = !settings.q.empty() || !settings.policy.empty() || !file.collisions.when.empty();
  Model model = model_of_counts(parts, names, tries, with_readings);
  // NOLINTNEXTLINE(clang-analyzer-cplusplus.NewDeleteLeaks): loses sight of a std::function that is moved
  auto policy = policy_of_log(settings, model, tries, solving, during("solving"), report);
  if (!policy) {
    return tl::unexpected(policy.error());
  }
  const auto value = value_of_policy(model, policy->policy, solving, during("valuing"));
  if (!value) {
    return tl::unexpected(value.error());
  }
  report.value = *value;
  report.count_error = 0.0;  // the counts are what the log holds
  if (auto ok = collide_by_test(file.collisions.when, model, parts); !ok) {
    return ok;
  }
  give_back(model, parts);
  parts.q = std::move(policy->q);
  parts.policy = std::move(policy->policy);
  return {};
}

}  // namespace coppice
