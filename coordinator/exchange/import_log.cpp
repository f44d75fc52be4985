#include "coordinator/exchange/import_log.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <utility>

#include "common/check.hpp"
#include "coordinator/exchange/log_chain.hpp"
#include "coordinator/exchange/log_passes.hpp"
#include "coordinator/exchange/log_policy.hpp"

namespace coppice {
namespace {

constexpr double kUsualDiscount = 0.99;  // where nobody said one

Result<void> check_log_flags(const ImportSettings& settings) {
  const ProblemFile& file = settings.problem;
  const bool given = !settings.q.empty() || !settings.policy.empty();
  if (settings.solve && given) {
    return bad_input("--solve makes Q-values and policy: expected it without --q and --policy");
  }
  if (settings.min_visits > 1 && !settings.solve) {
    return bad_input("--min-visits says what --solve may take: expected it with --solve");
  }
  if (!file.without_actions.empty() || file.look_alikes == LookAlikes::merge) {
    return bad_input(
        "a log's states are what is observed, and its actions what was done: expected no action to leave "
        "out and nothing to merge");
  }
  if (!file.collisions.label.empty() || !file.collisions.shares.empty() || !file.terminals.empty() ||
      !file.initial.empty()) {
    return bad_input(
        "a log says itself where episodes start and end, and its states have no labels or numbers: expected "
        "collisions "
        "by reward or test, and no terminals or initial states");
  }
  return {};
}

std::vector<std::uint64_t> tries_of(const ChainParts& parts) {
  std::vector<std::uint64_t> tries(parts.row_begin.size() - 1, 0);
  for (std::size_t row = 0; row < tries.size(); ++row) {
    for (std::uint64_t i = parts.row_begin[row]; i < parts.row_begin[row + 1]; ++i) {
      tries[row] += parts.count[i];
    }
  }
  return tries;
}

// Visits of the states, and what the report says about how the log was tried.
void sum_up_tries(const std::vector<std::uint64_t>& tries, ChainParts& parts, ImportReport& report) {
  const std::size_t actions = parts.vocabulary.actions.size();
  const std::size_t states = tries.size() / actions;
  parts.visits.assign(states, 0);
  std::vector<bool> terminal(states, false);
  for (const std::uint32_t state : parts.terminals) {
    terminal[state] = true;
  }
  std::uint64_t other = 0;
  std::uint64_t all = 0;
  for (std::size_t state = 0; state < states; ++state) {
    const auto begin = tries.begin() + static_cast<std::ptrdiff_t>(state * actions);
    const auto end = begin + static_cast<std::ptrdiff_t>(actions);
    for (auto row = begin; row != end; ++row) {
      parts.visits[state] += *row;
      report.never_tried += *row == 0 && !terminal[state] ? 1 : 0;
    }
    report.contradictions += std::count_if(begin, end, [](std::uint64_t n) { return n > 0; }) > 1 ? 1 : 0;
    all += parts.visits[state];
    other += parts.visits[state] - *std::max_element(begin, end);
  }
  const bool binned = std::any_of(parts.vocabulary.features.begin(), parts.vocabulary.features.end(),
                                  [](const Feature& feature) { return feature.scale == Scale::bins; });
  if (binned && all > 0) {
    report.bin_disagreement = static_cast<double>(other) / static_cast<double>(all);
  }
}

// The discount or horizon that values are computed with.
Result<SolveSettings> solving_of(const ImportSettings& settings, const std::optional<double>& said,
                                 ImportReport& report) {
  SolveSettings solving;
  solving.horizon = settings.horizon;
  solving.gamma = said.value_or(settings.horizon ? 1.0 : kUsualDiscount);
  if (auto ok = check_settings(solving); !ok) {
    return tl::unexpected(ok.error());
  }
  if (!said && !settings.horizon && settings.q.empty()) {
    report.notes.push_back(fmt::format("Nobody said a discount (--gamma): {} is taken.", kUsualDiscount));
  }
  return solving;
}

}  // namespace

Result<Imported> import_log(const ImportSettings& settings, SourceFormat format, const ImportProgress& go_on) {
  COPPICE_CHECK(format == SourceFormat::csv_log || format == SourceFormat::json_log);
  if (auto ok = check_log_flags(settings); !ok) {
    return tl::unexpected(ok.error());
  }
  ProblemFile file = settings.problem;
  auto log = count_log(settings, format, file, go_on);
  if (!log) {
    return tl::unexpected(log.error());
  }
  ImportReport report;
  report.format = name_of(format);
  report.steps = log->counter->steps();
  report.episodes = log->counter->episodes();
  report.truncated = log->counter->truncated();
  if (const std::uint64_t unfinished = log->counter->unfinished(); unfinished > 0) {
    report.notes.push_back(
        fmt::format("Of {} of the steps the log does not say where they led: not counted.", unfinished));
  }
  const std::vector<FeatureWish> wishes = wishes_of(log->header, file);
  auto parts = parts_of_log(*log, wishes, file, settings.source);
  if (!parts) {
    return tl::unexpected(parts.error());
  }
  const std::optional<double> discount = settings.gamma ? settings.gamma : file.discount;
  const auto solving = solving_of(settings, discount, report);
  if (!solving) {
    return tl::unexpected(solving.error());
  }
  {
    const std::vector<std::uint64_t> tries = tries_of(*parts);
    const LogNames names{log->header.features, log->actions};
    if (auto ok = value_log(settings, file, names, *solving, tries, go_on, *parts, report); !ok) {
      return tl::unexpected(ok.error());
    }
    sum_up_tries(tries, *parts, report);
  }
  fill_ends(file.terminal, *parts);
  const auto no_action = no_action_of(file, log->actions);
  if (!no_action) {
    return tl::unexpected(no_action.error());
  }
  parts->no_action = *no_action;
  parts->look_alikes = !parts->terminals.empty();  // an end may read as a state that goes on
  auto problem = problem_of_log(*log, wishes, file, parts->vocabulary, discount);
  if (!problem) {
    return tl::unexpected(problem.error());
  }
  problem->source = fmt::format("{} ({} log)", settings.source, format == SourceFormat::csv_log ? "CSV" : "JSON lines");
  auto chain = Chain::make(std::move(*parts));
  if (!chain) {
    return tl::unexpected(chain.error());
  }
  return Imported{std::move(*chain), std::move(*problem), std::move(report)};
}

}  // namespace coppice
