#include "coordinator/sweep/sweep_report.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <iterator>
#include <nlohmann/json.hpp>

#include "common/tree/text.hpp"
#include "coordinator/console/json_line.hpp"
#include "coordinator/sweep/summary.hpp"

namespace coppice {
namespace {

using Json = nlohmann::ordered_json;

// A setting with the runs of it that have ended.
struct Row {
  std::size_t setting = 0;
  std::vector<const SweepResult*> runs;
  std::vector<std::uint64_t> seeds;

  Summary summary(std::size_t measure) const {
    std::vector<double> values;
    values.reserve(runs.size());
    for (const SweepResult* run : runs) {
      values.push_back(value_of(*run, measure));
    }
    return summary_of(std::move(values));
  }
  // The highest fitness, the earlier seed in a tie: an index.
  std::size_t best() const {
    std::size_t best = 0;
    for (std::size_t i = 1; i < runs.size(); ++i) {
      best = runs[i]->fitness > runs[best]->fitness ? i : best;
    }
    return best;
  }
};

std::vector<Row> rows_of(const SweepPlan& plan, const SweepResults& results) {
  std::vector<Row> rows;
  for (std::size_t setting = 0; setting < plan.settings.size(); ++setting) {
    Row row{setting, {}, {}};
    for (std::size_t i = 0; i < plan.seeds.size(); ++i) {
      if (const auto& result = results[setting * plan.seeds.size() + i]) {
        row.runs.push_back(&*result);
        row.seeds.push_back(plan.seeds[i]);
      }
    }
    if (!row.runs.empty()) {
      rows.push_back(std::move(row));
    }
  }
  return rows;
}

bool is_simulated(const std::vector<Row>& rows) { return !rows.empty() && rows.front().runs.front()->simulated; }

// RFC 4180: quoted where it must be.
std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) {
    return text;
  }
  std::string quoted = "\"";
  for (const char c : text) {
    quoted += c == '"' ? "\"\"" : std::string(1, c);
  }
  return quoted + "\"";
}

std::string keys_csv(const SweepPlan& plan) {
  std::string text;
  for (const std::string& key : plan.keys) {
    text += csv_field(key) + ",";
  }
  return text;
}

std::string values_csv(const SweepPlan& plan, std::size_t setting) {
  std::string text;
  for (const std::string& value : plan.settings[setting].values) {
    text += csv_field(value) + ",";
  }
  return text;
}

Json values_json(const SweepPlan& plan, std::size_t setting) {
  Json json = Json::object();
  for (std::size_t i = 0; i < plan.keys.size(); ++i) {
    json[plan.keys[i]] = plan.settings[setting].values[i];
  }
  return json;
}

}  // namespace

std::string to_text(const SweepPlan& plan, const SweepResults& results) {
  const std::vector<Row> rows = rows_of(plan, results);
  if (rows.empty()) {
    return "no run has ended\n";
  }
  const auto& columns = sweep_columns(is_simulated(rows));
  std::size_t width = 0;
  for (const Row& row : rows) {
    width = std::max(width, plan.label(row.setting).size());
  }
  constexpr std::size_t kColumn = 16;
  std::string text = fmt::format("{:{}}  runs", "setting", width);
  for (const SweepColumn& measure : columns) {
    fmt::format_to(std::back_inserter(text), "  {:>{}}", measure.title, kColumn);
  }
  text += "\n";
  for (const Row& row : rows) {
    fmt::format_to(std::back_inserter(text), "{:{}}  {:4}", plan.label(row.setting), width, row.runs.size());
    for (std::size_t m = 0; m < columns.size(); ++m) {
      const Summary summary = row.summary(m);
      const SweepColumn& measure = columns[m];
      const std::string cell = fmt::format("{:.{}f} +-{:.{}f}", summary.mean * measure.scale, measure.decimals,
                                           summary.margin * measure.scale, measure.decimals);
      fmt::format_to(std::back_inserter(text), "  {:>{}}", cell, kColumn);
    }
    text += "\n";
  }
  text +=
      "means with 95 % intervals (Student's t) over the runs; distinct: different trees in a generation,\n"
      "meanings: different action tables in it\n";
  const auto best = std::max_element(rows.begin(), rows.end(),
                                     [](const Row& a, const Row& b) { return a.summary(2).mean < b.summary(2).mean; });
  fmt::format_to(std::back_inserter(text), "highest mean fitness: {}; its best run: seed {}\n",
                 plan.label(best->setting), best->seeds[best->best()]);
  return text;
}

std::string settings_csv(const SweepPlan& plan, const SweepResults& results) {
  const std::vector<Row> rows = rows_of(plan, results);
  const auto& columns = sweep_columns(is_simulated(rows));
  std::string text = keys_csv(plan) + "runs";
  for (const SweepColumn& measure : columns) {
    fmt::format_to(std::back_inserter(text), ",{0}_mean,{0}_deviation,{0}_interval,{0}_median,{0}_low,{0}_high",
                   measure.name);
  }
  text += "\n";
  for (const Row& row : rows) {
    text += values_csv(plan, row.setting) + fmt::format("{}", row.runs.size());
    for (std::size_t m = 0; m < columns.size(); ++m) {
      const Summary summary = row.summary(m);
      fmt::format_to(std::back_inserter(text), ",{},{},{},{},{},{}", summary.mean, summary.deviation, summary.margin,
                     summary.median, summary.low, summary.high);
    }
    text += "\n";
  }
  return text;
}

std::string runs_csv(const SweepPlan& plan, const SweepResults& results, const Vocabulary& vocabulary) {
  const std::vector<Row> rows = rows_of(plan, results);
  const auto& columns = sweep_columns(is_simulated(rows));
  std::string text = keys_csv(plan) + "seed";
  for (const SweepColumn& measure : columns) {
    text += "," + measure.name;
  }
  text += ",tree\n";
  for (const Row& row : rows) {
    for (std::size_t i = 0; i < row.runs.size(); ++i) {
      text += values_csv(plan, row.setting) + fmt::format("{}", row.seeds[i]);
      for (std::size_t m = 0; m < columns.size(); ++m) {
        fmt::format_to(std::back_inserter(text), ",{}", value_of(*row.runs[i], m));
      }
      text += "," + csv_field(to_text(row.runs[i]->tree, vocabulary)) + "\n";
    }
  }
  return text;
}

std::string to_json(const SweepPlan& plan, const SweepResults& results, const Vocabulary& vocabulary) {
  const std::vector<Row> rows = rows_of(plan, results);
  const auto& columns = sweep_columns(is_simulated(rows));
  Json settings = Json::array();
  for (const Row& row : rows) {
    Json json = {{"setting", values_json(plan, row.setting)}, {"runs", row.runs.size()}};
    for (std::size_t m = 0; m < columns.size(); ++m) {
      const Summary summary = row.summary(m);
      json[columns[m].name] = {{"mean", summary.mean},       {"deviation", summary.deviation},
                               {"interval", summary.margin}, {"median", summary.median},
                               {"low", summary.low},         {"high", summary.high}};
    }
    const std::size_t best = row.best();
    json["best"] = {{"seed", row.seeds[best]},
                    {"fitness", row.runs[best]->fitness},
                    {"tree", to_text(row.runs[best]->tree, vocabulary)}};
    settings.push_back(std::move(json));
  }
  return json_line({{"settings", settings}});
}

std::optional<IntervalPlot> plot_of(const SweepPlan& plan, const SweepResults& results, const std::string& title) {
  const std::vector<Row> rows = rows_of(plan, results);
  if (rows.empty()) {
    return std::nullopt;
  }
  IntervalPlot plot;
  plot.title = title;
  for (const Row& row : rows) {
    plot.settings.push_back(plan.label(row.setting));
  }
  const auto& columns = sweep_columns(is_simulated(rows));
  for (std::size_t m = 0; m < columns.size(); ++m) {
    PlotPanel panel{columns[m].title, {}};
    for (const Row& row : rows) {
      const Summary summary = row.summary(m);
      const double scale = columns[m].scale;
      panel.points.push_back(
          {summary.mean * scale, (summary.mean - summary.margin) * scale, (summary.mean + summary.margin) * scale});
    }
    plot.panels.push_back(std::move(panel));
  }
  return plot;
}

}  // namespace coppice
