#include <CLI/CLI.hpp>
#include <cmath>
#include <fmt/format.h>
#include <malloc.h>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "coordinator/commands/commands.hpp"
#include "coordinator/commands/shared_flags.hpp"
#include "coordinator/commands/whole_number.hpp"
#include "coordinator/console/counted.hpp"
#include "coordinator/console/json_line.hpp"
#include "coordinator/console/printable.hpp"
#include "coordinator/console/progress.hpp"
#include "coordinator/exchange/import_source.hpp"
#include "coordinator/exchange/solve.hpp"
#include "coordinator/learning/world.hpp"
#include "coordinator/study/study.hpp"

namespace coppice {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::uint64_t kShares = 100;  // of the progress bar

struct ImportFlags {
  std::string source;
  std::string study;
  std::string problem;
  std::string q;
  std::string policy;
  std::string format;
  std::string reward;
  std::string simulator;
  std::string no_action;
  std::vector<std::string> without;
  bool solve = false;
  std::uint64_t min_visits = 1;
  bool merge = false;
  bool again = false;
  std::optional<double> gamma;
  std::optional<std::uint32_t> horizon;
  bool json = false;
};

// A bar for each thing that is done.
class ImportBar {
 public:
  ImportBar(std::FILE* out, const StopFlag& stop) : out_(out), stop_(stop) {}
  ~ImportBar() { end(); }
  ImportBar(const ImportBar&) = delete;
  ImportBar& operator=(const ImportBar&) = delete;

  bool show(std::string_view what, double share) {
    if (what != what_) {
      end();
      what_ = what;
      bar_.emplace(out_, progress_settings_for(out_), std::string(what), "%", kShares);
    }
    bar_->update(static_cast<std::uint64_t>(std::llround(share * static_cast<double>(kShares))));
    return !stop_.raised();
  }

 private:
  void end() { bar_.reset(); }

  std::FILE* out_;
  const StopFlag& stop_;
  std::string what_;
  std::optional<Progress> bar_;
};

Result<ImportSettings> settings_of(const ImportFlags& options) {
  ImportSettings settings;
  settings.source = options.source;
  if (!options.problem.empty()) {
    auto file = read_problem_file(options.problem);
    if (!file) {
      return tl::unexpected(file.error());
    }
    settings.problem = std::move(*file);
  }
  if (!options.format.empty()) {
    const auto format = value_named<SourceFormat>("format", options.format);
    if (!format) {
      return in_context("--format", format.error());
    }
    settings.format = *format;
  }
  ProblemFile& problem = settings.problem;
  problem.reward = options.reward.empty() ? problem.reward : options.reward;
  problem.simulator = options.simulator.empty() ? problem.simulator : options.simulator;
  problem.no_action = options.no_action.empty() ? problem.no_action : options.no_action;
  problem.without_actions.insert(problem.without_actions.end(), options.without.begin(), options.without.end());
  problem.look_alikes = options.merge ? LookAlikes::merge : problem.look_alikes;
  problem.terminal = options.again ? WhenTerminal::again : problem.terminal;
  settings.q = options.q;
  settings.policy = options.policy;
  settings.solve = options.solve;
  settings.min_visits = options.min_visits;
  settings.gamma = options.gamma;
  settings.horizon = options.horizon;
  return settings;
}

Json or_null(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

Json json_of(const Imported& imported) {
  const Chain& chain = imported.chain;
  const ImportReport& report = imported.report;
  Json json = {{"format", report.format},
               {"states", chain.states()},
               {"actions", chain.actions()},
               {"features", chain.vocabulary().features.size()},
               {"transitions", chain.transitions()},
               {"starts", chain.starts().size()},
               {"terminal_states", chain.parts().terminals.size()},
               {"value", or_null(report.value)},
               {"count_error", or_null(report.count_error)},
               {"lost_transitions", report.lost_transitions},
               {"unreachable_states", report.unreachable_states},
               {"look_alikes", report.look_alikes},
               {"ties", report.ties}};
  if (imported.problem.discount) {
    json["discount"] = *imported.problem.discount;
  }
  if (report.sweeps) {
    json["sweeps"] = *report.sweeps;
    json["bound"] = or_null(report.bound);
  }
  if (report.merged_states > 0) {
    json["merged_states"] = report.merged_states;
    json["merged_value"] = or_null(report.merged_value);
  }
  if (report.steps > 0) {
    json["steps"] = report.steps;
    json["episodes"] = report.episodes;
    json["truncated_episodes"] = report.truncated;
    json["never_tried"] = report.never_tried;
    json["contradictions"] = report.contradictions;
    json["bin_disagreement"] = or_null(report.bin_disagreement);
    if (report.sweeps) {
      json["solved_on_one_try"] = report.solved_on_one_try;
      json["distrusted"] = report.distrusted;
    }
  }
  json["notes"] = report.notes;
  return json;
}

std::string text_of(const Imported& imported, const std::string& study) {
  const Chain& chain = imported.chain;
  const ImportReport& report = imported.report;
  std::string text =
      fmt::format("{}: {}, {}, {}, {} (from {})\n", printable(study), counted(chain.states(), "state"),
                  counted(chain.actions(), "action"), counted(chain.vocabulary().features.size(), "feature"),
                  counted(chain.transitions(), "transition"), printable(imported.problem.source));
  const auto line = [&text](const std::string& name, const std::string& value) {
    text += fmt::format("{:<22} {}\n", name, printable(value));
  };
  std::string features;
  for (const Feature& feature : chain.vocabulary().features) {
    features += fmt::format("{}{} ({}{})", features.empty() ? "" : ", ", feature.name,
                            counted(feature.values.size(), feature.scale == Scale::bins ? "bin" : "value"),
                            feature.scale == Scale::bins ? ", <= only" : "");
  }
  line("features", features);
  if (report.steps > 0) {
    line("log",
         fmt::format("{} in {}, {} cut off; {} never tried", counted(report.steps, "step"),
                     counted(report.episodes, "episode"), report.truncated, counted(report.never_tried, "pair")));
  }
  if (report.value) {
    line("value of the policy", fmt::format("{:.10g}", *report.value));
  }
  if (report.count_error) {
    line("changed by counting", fmt::format("{:.3g}", *report.count_error));
  }
  if (report.bound) {
    line("solved",
         fmt::format("{}, value within {:.2g} of the optimum", counted(*report.sweeps, "sweep"), *report.bound));
  }
  const auto unless_none = [&](const char* name, std::uint64_t count, const std::string& what) {
    if (count > 0) {
      line(name, what);
    }
  };
  unless_none("ties", report.ties, fmt::format("in {} another action is as good", counted(report.ties, "state")));
  unless_none("contradictions", report.contradictions,
              fmt::format("in {} the log holds different actions", counted(report.contradictions, "state")));
  if (report.bin_disagreement) {
    line("lost by binning",
         fmt::format("in {:.2f} % of the steps the action is not that of the state", 100.0 * *report.bin_disagreement));
  }
  unless_none("unreachable", report.unreachable_states,
              fmt::format("{} left out", counted(report.unreachable_states, "state")));
  unless_none("look-alikes", report.look_alikes,
              fmt::format("{} read the same as another one; a tree cannot tell them apart",
                          counted(report.look_alikes, "state")));
  unless_none("merged", report.merged_states,
              fmt::format("{} into others that read the same{}", counted(report.merged_states, "state"),
                          report.merged_value
                              ? fmt::format("; one action for all of a kind is worth {:.10g}", *report.merged_value)
                              : ""));
  unless_none("lost transitions", report.lost_transitions,
              "too improbable for a count: " + counted(report.lost_transitions, "transition"));
  for (const std::string& note : report.notes) {
    text += printable(note) + "\n";
  }
  return text;
}

// Arrays of this size and more go back to the system when they are freed, however large others were: a log takes and
// frees several as large as its chain, and what stays between them would be a third of the peak.
constexpr int kMappedFrom = 1 << 18;  // bytes

Result<void> import_command(const ImportFlags& options, const StopFlag& stop) {
  static_cast<void>(mallopt(M_MMAP_THRESHOLD, kMappedFrom));
  const auto settings = settings_of(options);
  if (!settings) {
    return tl::unexpected(settings.error());
  }
  if (const Result<void> checked = Study::check_new(options.study); !checked) {
    return checked;
  }
  auto imported = [&] {
    ImportBar bar(stderr, stop);
    return import_source(*settings, [&bar](std::string_view what, double share) { return bar.show(what, share); });
  }();
  if (!imported) {
    return tl::unexpected(imported.error());
  }
  const Json report = json_of(*imported);
  const std::string text = text_of(*imported, options.study);
  const Result<ChainHash> chain =
      Study::write_new(options.study, std::move(imported->chain), {kNoWorld, ""},
                       {json_line(Json{{"import", options.source}}), json_line(report)}, imported->problem);
  if (!chain) {
    return tl::unexpected(chain.error());
  }
  if (options.json) {
    Json json = {{"study", options.study}, {"chain", chain->hex()}};
    json.update(report);
    fmt::print("{}\n", json_line(json));
  } else {
    fmt::print("{}", text);
  }
  return {};
}

}  // namespace

void add_import(CLI::App& app, Invocation& invocation) {
  const auto options = std::make_shared<ImportFlags>();
  CLI::App* command = app.add_subcommand("import", "Start a study from a model, a table or a log of another tool");
  command
      ->add_option("SOURCE", options->source,
                   "Storm DRN, PRISM explicit (.tra), Gymnasium P tables (JSON), or a log of transitions (CSV, JSON "
                   "lines); told from its content")
      ->required();
  command->add_option("-o,--output", options->study, "The study file to make; must not exist")
      ->type_name("STUDY")
      ->required();
  command->add_option("--problem", options->problem, "Names, labels, units, bins, collisions, starts (see README)")
      ->type_name("FILE.toml");
  command->add_option("--q", options->q, "Q-values [states x actions] (.npy or CSV)")->type_name("FILE");
  command->add_option("--policy", options->policy, "The policy: an action for each state (.npy or CSV)")
      ->type_name("FILE");
  command->add_flag("--solve", options->solve, "Make Q-values and policy: the best ones");
  command
      ->add_option("--min-visits", options->min_visits,
                   "Of a log: --solve takes no action that was tried fewer times, where the state has another")
      ->type_name("N")
      ->check(whole_number())
      ->capture_default_str();
  command->add_option("--gamma", options->gamma, "Discount, of solving and of the value reported")
      ->type_name("G")
      ->check(CLI::Range(0.0, 1.0));
  command->add_option("--horizon", options->horizon, "Steps of an episode, instead of for ever")
      ->type_name("STEPS")
      ->check(whole_number(1, kMaxHorizon));
  command->add_option("--format", options->format, "drn, prism, tables, csv or jsonl, where the content does not tell");
  command->add_option("--reward", options->reward, "Which reward of the model, as in 'gain - cost'")->type_name("NAME");
  command->add_option("--without", options->without, "Leave an action out; may be repeated")
      ->type_name("ACTION")
      ->allow_extra_args(false);
  command->add_option("--no-action", options->no_action,
                      "What happens when a tree chooses nothing: worst (default), hold, or an action");
  command->add_flag("--merge", options->merge, "States that read the same become one (default: kept apart)");
  command->add_flag("--again", options->again, "Episodes that end start again (default: they stay where they ended)");
  command->add_option("--simulator", options->simulator, "The problem's own simulator, kept in the study")
      ->type_name("COMMAND");
  add_json_flag(*command, options->json);
  command->footer(
      "Examples:\n"
      "  coppice import maze.drn -o maze.coppice --solve --gamma 0.99\n"
      "  coppice import log.csv -o robot.coppice --problem robot.toml --gamma 0.95");
  command->callback([&invocation, options] {
    invocation.chosen = [&invocation, options] { return import_command(*options, invocation.stop); };
  });
}

}  // namespace coppice
