#include "coordinator/exchange/import_source.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

#include "coordinator/exchange/chain_of_model.hpp"
#include "coordinator/exchange/drn.hpp"
#include "coordinator/exchange/given_policy.hpp"
#include "coordinator/exchange/import_log.hpp"
#include "coordinator/exchange/p_tables.hpp"
#include "coordinator/exchange/prism.hpp"
#include "coordinator/exchange/solve.hpp"

namespace coppice {
namespace {

std::string words_of(SourceFormat format) {
  switch (format) {
    case SourceFormat::drn:
      return "Storm DRN";
    case SourceFormat::prism:
      return "PRISM explicit";
    case SourceFormat::tables:
      return "P tables";
    case SourceFormat::csv_log:
      return "CSV log";
    case SourceFormat::json_log:
      break;
  }
  return "JSON lines log";
}

Result<ModelValuation> valuation_of(const ImportSettings& settings) {
  ModelValuation valuation;
  const std::optional<double> gamma = settings.gamma ? settings.gamma : settings.problem.discount;
  valuation.settings.horizon = settings.horizon;
  valuation.settings.gamma = gamma.value_or(1.0);
  valuation.known = gamma.has_value() || settings.horizon.has_value();
  if (valuation.known) {
    if (auto ok = check_settings(valuation.settings); !ok) {
      return tl::unexpected(ok.error());
    }
  }
  return valuation;
}

Result<Model> read_model(const ImportSettings& settings, SourceFormat format, ProblemFile& problem) {
  switch (format) {
    case SourceFormat::drn:
      return read_drn(settings.source, problem.reward);
    case SourceFormat::prism:
      return read_prism(settings.source);
    case SourceFormat::tables: {
      auto tables = read_p_tables(settings.source, problem.collision_reward);
      if (!tables) {
        return tl::unexpected(tables.error());
      }
      fill_from_header(tables->header, problem);
      return std::move(tables->model);
    }
    default:
      return bad_input(fmt::format("{}: {} is no format of a model", settings.source, name_of(format)));
  }
}

Result<void> check_flags(const ImportSettings& settings, const ModelValuation& valuation) {
  const bool given = !settings.q.empty() || !settings.policy.empty();
  if (settings.solve && given) {
    return bad_input("--solve makes Q-values and policy: expected it without --q and --policy");
  }
  if (settings.min_visits > 1) {
    return bad_input("--min-visits is for logs: a model's probabilities are not counted");
  }
  if (settings.solve && !valuation.known) {
    return bad_input("--solve needs --gamma, a discount in the problem file, or --horizon");
  }
  if (!settings.solve && !given) {
    return bad_input(
        fmt::format("{}: a model without a policy: expected --solve with --gamma, --q or --policy", settings.source));
  }
  if (settings.q.empty() && !settings.policy.empty() && !valuation.known) {
    return bad_input(
        "--policy without --q needs --gamma, a discount in the problem file, or --horizon, to value actions");
  }
  return {};
}

// Q-values are the table's, the lowest of the state for what it does not have; without a table those of the policy.
Result<PolicyOfModel> given_policy(const ImportSettings& settings, const ModelValuation& valuation, Model& model,
                                   const SolveProgress& go_on, ImportReport& report) {
  auto given = read_given_policy(settings.q, settings.policy, model);
  if (!given) {
    return tl::unexpected(given.error());
  }
  if (auto ok = forbid(*given, model); !ok) {
    return in_context(settings.q, ok.error());
  }
  report.ties = given->ties;
  if (given->unlisted > 0) {
    report.notes.push_back(
        fmt::format("The table does not have {} of the states; the first action is taken there.", given->unlisted));
  }
  if (given->unvisited > 0) {
    report.notes.push_back(
        fmt::format("Of {} states all Q-values are 0: they were never visited, it seems.", given->unvisited));
  }
  PolicyOfModel policy{std::move(given->q), std::move(given->policy), {}};
  if (policy.q.empty()) {
    const auto values = values_of_policy(model, policy.policy, valuation.settings, go_on);
    if (!values) {
      return tl::unexpected(values.error());
    }
    policy.q = q_of_values(model, *values, valuation.settings.gamma);
    return policy;
  }
  for (std::size_t first = 0; first < policy.q.size(); first += model.actions()) {
    double lowest = std::numeric_limits<double>::infinity();
    for (std::size_t row = first; row < first + model.actions(); ++row) {
      lowest = std::isnan(policy.q[row]) ? lowest : std::min(lowest, policy.q[row]);
    }
    for (std::size_t row = first; row < first + model.actions(); ++row) {
      policy.q[row] = !std::isnan(policy.q[row]) ? policy.q[row] : (std::isinf(lowest) ? 0.0 : lowest);
    }
  }
  return policy;
}

Result<PolicyOfModel> solved_policy(const ModelValuation& valuation, const Model& model, const SolveProgress& go_on,
                                    ImportReport& report) {
  auto solution = solve(model, valuation.settings, go_on);
  if (!solution) {
    return tl::unexpected(solution.error());
  }
  report.ties = solution->ties;
  report.sweeps = solution->sweeps;
  report.bound = solution->bound;
  return PolicyOfModel{std::move(solution->q), std::move(solution->policy), {}};
}

// What is said of the import before the chain is made goes into that of the chain.
void add_to_report(const ImportReport& before, ImportReport& report) {
  report.format = before.format;
  report.unreachable_states = before.unreachable_states;
  report.ties = before.ties;
  report.sweeps = before.sweeps;
  report.bound = before.bound;
  report.notes.insert(report.notes.begin(), before.notes.begin(), before.notes.end());
}

Result<Imported> import_model(const ImportSettings& settings, SourceFormat format, const ImportProgress& go_on) {
  const auto during = [&go_on](std::string_view what) -> SolveProgress {
    return go_on ? SolveProgress([&go_on, what](double share) { return go_on(what, share); }) : SolveProgress();
  };
  ImportSettings wanted = settings;
  auto model = read_model(settings, format, wanted.problem);
  if (!model) {
    return tl::unexpected(model.error());
  }
  const auto valuation = valuation_of(wanted);
  if (!valuation) {
    return tl::unexpected(valuation.error());
  }
  if (auto ok = check_flags(settings, *valuation); !ok) {
    return tl::unexpected(ok.error());
  }
  if (auto ok = apply_problem(wanted.problem, *model); !ok) {
    return tl::unexpected(ok.error());
  }
  if (auto ok = check_model(*model); !ok) {
    return in_context(settings.source, ok.error());
  }
  ImportReport before;
  before.format = name_of(format);
  before.unreachable_states = keep_reachable(*model);
  // NOLINTNEXTLINE(clang-analyzer-cplusplus.NewDeleteLeaks): loses sight of a std::function that is moved
  auto policy = settings.solve ? solved_policy(*valuation, *model, during("solving"), before)
                               : given_policy(settings, *valuation, *model, during("valuing"), before);
  if (!policy) {
    return tl::unexpected(policy.error());
  }
  policy->weight =
      occupancy_of_policy(*model, policy->policy, valuation->known ? valuation->settings.gamma : kMostRemembered);
  wanted.problem.discount = settings.gamma ? settings.gamma : wanted.problem.discount;
  auto imported = chain_of_model(std::move(*model), std::move(*policy), wanted.problem, *valuation, during("counting"));
  if (!imported) {
    return imported;
  }
  imported->problem.source = fmt::format("{} ({})", settings.source, words_of(format));
  add_to_report(before, imported->report);
  return imported;
}

}  // namespace

Result<Imported> import_source(const ImportSettings& settings, const ImportProgress& go_on) {
  SourceFormat format = SourceFormat::drn;
  if (settings.format) {
    format = *settings.format;
  } else {
    const auto found = format_of(settings.source);
    if (!found) {
      return tl::unexpected(found.error());
    }
    format = *found;
  }
  const bool is_log = format == SourceFormat::csv_log || format == SourceFormat::json_log;
  return is_log ? import_log(settings, format, go_on) : import_model(settings, format, go_on);
}

}  // namespace coppice
