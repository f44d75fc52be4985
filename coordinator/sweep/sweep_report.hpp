// What a sweep found, as a table, as CSV, as JSON and as a picture. Settings without a finished run are left out.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/tree/vocabulary.hpp"
#include "coordinator/report/interval_plot.hpp"
#include "coordinator/sweep/plan.hpp"
#include "coordinator/sweep/sweep.hpp"

namespace coppice {

// By run of SweepPlan::runs(); none: has not ended.
using SweepResults = std::vector<std::optional<SweepResult>>;

// Mean +- interval for each setting and measure, and the best run of each.
std::string to_text(const SweepPlan& plan, const SweepResults& results);
// A row a setting: the grid's keys, the runs, and of each measure mean, deviation, interval, median, lowest, highest.
std::string settings_csv(const SweepPlan& plan, const SweepResults& results);
// A row a run: the grid's keys, the seed, every measure, the tree.
std::string runs_csv(const SweepPlan& plan, const SweepResults& results, const Vocabulary& vocabulary);
std::string to_json(const SweepPlan& plan, const SweepResults& results, const Vocabulary& vocabulary);
// Means with their intervals. None: no run has ended.
std::optional<IntervalPlot> plot_of(const SweepPlan& plan, const SweepResults& results, const std::string& title);

}  // namespace coppice
