#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fmt/format.h>
#include <memory>
#include <optional>
#include <thread>

#include "coordinator/commands/commands.hpp"
#include "coordinator/commands/evaluator_option.hpp"
#include "coordinator/commands/shared_flags.hpp"
#include "coordinator/commands/whole_number.hpp"
#include "coordinator/console/counted.hpp"
#include "coordinator/console/progress.hpp"
#include "coordinator/report/gnuplot.hpp"
#include "coordinator/runs/sweep_in_folder.hpp"
#include "coordinator/study/study.hpp"

namespace coppice {
namespace {

constexpr std::size_t kMostAtOnce = 256;
constexpr std::size_t kAtOnceOverWorkers = 128;  // one for each evaluating thread of the workers at least

struct SweepFlags {
  std::string study;
  std::string config;
  std::string folder;
  EvaluatorOption evaluator;
  std::optional<std::size_t> at_once;
  bool resume = false;
  bool json = false;
};

// The progress line of a sweep, made when it is known how much there is to do.
class SweepLine {
 public:
  void update(const SweepProgress& at) {
    if (!progress_) {
      progress_.emplace(stderr, progress_settings_for(stderr), "sweep", "generations", at.generations, at.done);
    }
    last_ = at;
    std::string extra = fmt::format("{} of {} ended", at.ended, counted(at.runs, "run"));
    if (at.workers > 0) {
      extra += ", " + counted(at.workers, "worker");
    }
    progress_->update(at.done, extra);
  }
  void finish() {
    if (progress_) {
      const double seconds = std::chrono::duration<double>(Clock::now() - begin_).count();
      progress_->finish(last_.done,
                        fmt::format("{} of {} ended in {:.1f} s", last_.ended, counted(last_.runs, "run"), seconds));
    }
  }

 private:
  Clock::time_point begin_ = Clock::now();
  SweepProgress last_;
  std::optional<Progress> progress_;
};

Result<void> sweep_command(const SweepFlags& options, const StopFlag& stop) {
  const Result<EvaluatorChoice> choice = evaluator_choice(options.evaluator);
  if (!choice) {
    return tl::unexpected(choice.error());
  }
  if (auto found = check_gnuplot(); !found) {
    return found;
  }
  const Result<Study> study = Study::open(options.study, Study::Access::read);
  if (!study) {
    return tl::unexpected(study.error());
  }
  const Vocabulary& vocabulary = study->chain().vocabulary();
  const Result<SweepPlan> plan = load_sweep(options.config, vocabulary);
  if (!plan) {
    return tl::unexpected(plan.error());
  }
  const std::size_t at_once = options.at_once.value_or(
      choice->kind == EvaluatorChoice::Kind::serial ? std::max<std::size_t>(std::thread::hardware_concurrency(), 1)
                                                    : kAtOnceOverWorkers);
  SweepLine line;
  const Result<SweepReport> report = sweep_in_folder(
      *study,
      {.plan = *plan, .evaluator = *choice, .folder = options.folder, .resume = options.resume, .at_once = at_once},
      stop, [&](const SweepProgress& at) { line.update(at); });
  line.finish();
  if (!report) {
    return tl::unexpected(report.error());
  }
  if (options.json) {
    fmt::print("{}\n", to_json(*plan, report->results, vocabulary));
  } else {
    const std::filesystem::path folder(options.folder);
    fmt::print("{}table: {}, {}\nplot: {}\n", to_text(*plan, report->results), (folder / "settings.csv").string(),
               (folder / "runs.csv").string(), (folder / "sweep.svg").string());
    if (report->at_home > 0) {
      fmt::print("{} individuals evaluated by the coordinator itself: sending them would have taken longer\n",
                 report->at_home);
    }
    if (report->rollbacks > 0) {
      fmt::print("rolled back {}, because a worker had answered wrongly: nothing of what it said is in the tables\n",
                 counted(report->rollbacks, "time"));
    }
  }
  if (!report->outcome) {
    const Error& error = report->outcome.error();
    return tl::unexpected(
        Error{error.kind, fmt::format("{}; go on with the same command and --resume", error.message)});
  }
  return {};
}

}  // namespace

void add_sweep(CLI::App& app, Invocation& invocation) {
  const auto options = std::make_shared<SweepFlags>();
  CLI::App* command = app.add_subcommand("sweep", "Study parameters: many runs on one set of workers at once");
  add_study_argument(*command, options->study, "The study file; it is only read");
  command->add_option("--config", options->config, "Which settings, with which seeds (see below)")
      ->type_name("FILE.toml")
      ->required();
  command->add_option("-o,--output", options->folder, "The folder to make for tables and plot")
      ->type_name("FOLDER")
      ->required();
  add_evaluator_option(*command, options->evaluator);
  command
      ->add_option(
          "--at-once", options->at_once,
          "Runs that share the workers (default: 128); with --serial the threads that run them (default: one a "
          "core)")
      ->type_name("N")
      ->check(whole_number(1, kMostAtOnce));
  command->add_flag("--resume", options->resume, "Go on in a folder that exists: runs that have ended are kept");
  add_json_flag(*command, options->json);
  command->footer(
      "FILE.toml:\n"
      "  seeds = 10                     # runs of each setting; or a list of seeds\n"
      "  config = \"base.toml\"           # what all start from; left out: the defaults\n"
      "  episodes = 500                 # in the simulator, for each answer; 0: none\n"
      "  [set]                          # the same in all runs\n"
      "  ga.generations = 150\n"
      "  [grid]                         # every combination is a setting\n"
      "  ga.population = [50, 100]\n"
      "  rollout.acting = [\"tree\", \"policy\"]\n"
      "Writes settings.csv, runs.csv, runs.jsonl (what --resume goes on from) and sweep.svg. Every run ends as it "
      "would\n"
      "alone, whatever runs beside it. Ctrl-C keeps the runs that have ended. A run travels to a worker as a whole, or "
      "in\n"
      "epochs where it has several demes (ga.demes), so that even runs as short as the thesis' gain by workers.\n"
      "Example:\n"
      "  coppice sweep uav.coppice --config FILE.toml -o acting --workers 2");
  command->callback([&invocation, options] {
    invocation.chosen = [&invocation, options] { return sweep_command(*options, invocation.stop); };
  });
}

}  // namespace coppice
