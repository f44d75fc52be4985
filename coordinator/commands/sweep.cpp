#include "coordinator/sweep/sweep.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <cstdio>
#include <filesystem>
#include <fmt/format.h>
#include <memory>
#include <optional>
#include <system_error>
#include <thread>

#include "coordinator/commands/commands.hpp"
#include "coordinator/commands/evaluator_option.hpp"
#include "coordinator/commands/learn_options.hpp"
#include "coordinator/commands/simulate_option.hpp"
#include "coordinator/commands/whole_number.hpp"
#include "coordinator/dispatch/serial_evaluator.hpp"
#include "coordinator/report/counted.hpp"
#include "coordinator/report/gnuplot.hpp"
#include "coordinator/report/interval_plot.hpp"
#include "coordinator/report/progress.hpp"
#include "coordinator/report/whole_file.hpp"
#include "coordinator/study/study.hpp"
#include "coordinator/sweep/journal.hpp"
#include "coordinator/sweep/sweep_report.hpp"

namespace coppice {
namespace {

constexpr std::size_t kMostAtOnce = 256;
constexpr std::size_t kAtOnceOverWorkers = 16;

struct Options {
  std::string study;
  std::string config;
  std::string folder;
  EvaluatorOption evaluator;
  std::optional<std::size_t> at_once;
  bool resume = false;
  bool json = false;
};

Result<void> prepare_folder(const Options& options) {
  std::error_code error;
  if (std::filesystem::create_directory(options.folder, error)) {
    return {};
  }
  if (error) {
    return failed(fmt::format("cannot make the folder {}: {}", options.folder, error.message()));
  }
  if (!options.resume) {
    return bad_input(fmt::format("-o: {} exists already: expected the name of a new folder, or --resume to go on in it",
                                 options.folder));
  }
  return {};
}

Result<void> write_reports(const std::filesystem::path& folder, const SweepPlan& plan, const SweepResults& results,
                           const Study& study) {
  const Vocabulary& vocabulary = study.chain().vocabulary();
  if (const auto written = write_whole_file(folder / "settings.csv", settings_csv(plan, results)); !written) {
    return written;
  }
  if (const auto written = write_whole_file(folder / "runs.csv", runs_csv(plan, results, vocabulary)); !written) {
    return written;
  }
  const auto plot = plot_of(plan, results, fmt::format("{}: means and 95 % intervals", study.path()));
  return plot ? write_plot(*plot, folder / "sweep.svg") : Result<void>();
}

Result<void> sweep_command(const Options& options, const StopFlag& stop) {
  Result<EvaluatorChoice> choice = evaluator_choice(options.evaluator);
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
  const Result<SweepPlan> plan = load_sweep(options.config, study->chain().vocabulary());
  if (!plan) {
    return tl::unexpected(plan.error());
  }
  std::optional<World> world;
  if (plan->episodes > 0) {
    auto made = world_of(*study);
    if (!made) {
      return tl::unexpected(made.error());
    }
    world = std::move(*made);
  }
  std::atomic<bool> taken_back{false};
  choice->taken_back = [&taken_back] { taken_back = true; };
  const auto chain = std::make_shared<const Chain>(study->chain());
  const bool serial = choice->kind == EvaluatorChoice::Kind::serial;
  std::unique_ptr<EvaluatorPool> pool;
  if (!serial) {
    auto opened = open_pool(chain, *choice, stop);
    if (!opened) {
      return tl::unexpected(opened.error());
    }
    pool = std::move(*opened);
  }
  if (auto ok = prepare_folder(options); !ok) {
    return ok;
  }
  const std::filesystem::path folder(options.folder);
  auto journal = SweepJournal::open(folder / "runs.jsonl", study->chain_hash(), plan->episodes, chain->vocabulary());
  if (!journal) {
    return tl::unexpected(journal.error());
  }

  const std::vector<SweepRun> all = plan->runs();
  SweepResults results(all.size());
  std::vector<SweepRun> missing;
  std::vector<std::size_t> places;  // of the missing in all
  std::uint64_t generations = 0;    // in all of them
  std::uint64_t done = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    generations += all[i].config.ga.generations;
    if (const SweepResult* const known = journal->find(all[i].config); known != nullptr) {
      results[i] = *known;
      done += all[i].config.ga.generations;
    } else {
      missing.push_back(all[i]);
      places.push_back(i);
    }
  }
  std::size_t ended = all.size() - missing.size();

  SweepSettings settings;
  settings.at_once = options.at_once.value_or(serial ? std::max<std::size_t>(std::thread::hardware_concurrency(), 1)
                                                     : kAtOnceOverWorkers);
  const auto prepared = serial ? PreparedChain::make(chain) : nullptr;
  settings.new_evaluator = [&]() -> std::unique_ptr<Evaluator> {
    return serial ? SerialEvaluator::make(prepared, stop) : pool->client();
  };
  settings.episodes = plan->episodes;
  settings.steps = world ? learned_steps(*study) : settings.steps;
  Progress progress(stderr, progress_settings_for(stderr), "sweep", "generations", generations, done);
  SweepHooks hooks;
  hooks.run_done = [&](std::size_t run, const SweepResult& result) {
    results[places[run]] = result;
    ++ended;
    return journal->add(missing[run].config, result);
  };
  hooks.generation_done = [&] {
    std::string extra = fmt::format("{} of {} ended", ended, counted(all.size(), "run"));
    if (pool != nullptr) {
      extra += ", " + counted(pool->statistics().workers_alive, "worker");
    }
    progress.update(++done, extra);
  };
  const Clock::time_point begin = Clock::now();
  const Result<void> swept = sweep(*chain, world ? &*world : nullptr, missing, settings, hooks, stop);
  const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  progress.finish(done, fmt::format("{} of {} ended in {:.1f} s", ended, counted(all.size(), "run"), seconds));

  if (const auto written = write_reports(folder, *plan, results, *study); !written) {
    return written;
  }
  if (options.json) {
    fmt::print("{}\n", to_json(*plan, results, chain->vocabulary()));
  } else {
    fmt::print("{}table: {}, {}\nplot: {}\n", to_text(*plan, results), (folder / "settings.csv").string(),
               (folder / "runs.csv").string(), (folder / "sweep.svg").string());
  }
  if (!swept) {
    const char* const next = taken_back
                                 ? "runs that have ended may rest on that: begin the sweep again in another folder"
                                 : "go on with the same command and --resume";
    return tl::unexpected(Error{swept.error().kind, fmt::format("{}; {}", swept.error().message, next)});
  }
  return {};
}

}  // namespace

void add_sweep(CLI::App& app, Invocation& invocation) {
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("sweep", "Study parameters: many runs on one set of workers at once");
  command->add_option("STUDY", options->study, "The study file; it is only read")->required();
  command->add_option("--config", options->config, "Which settings, with which seeds (see below)")
      ->type_name("FILE.toml")
      ->required();
  command->add_option("-o,--output", options->folder, "The folder to make for tables and plot")
      ->type_name("FOLDER")
      ->required();
  add_evaluator_option(*command, options->evaluator);
  command
      ->add_option("--at-once", options->at_once,
                   "Runs that share the workers (default: 16); with --serial the threads that run them (default: one a "
                   "core)")
      ->type_name("N")
      ->check(whole_number(1, kMostAtOnce));
  command->add_flag("--resume", options->resume, "Go on in a folder that exists: runs that have ended are kept");
  command->add_flag("--json", options->json, "Report as one JSON object");
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
      "alone, whatever runs beside it. Ctrl-C keeps the runs that have ended. Where a generation takes less than a "
      "few\n"
      "milliseconds, as in the thesis, --serial is the fastest on one machine: sending it costs more than evaluating "
      "it.\n"
      "Example:\n"
      "  coppice sweep uav.coppice --config FILE.toml -o acting --workers 2");
  command->callback([&invocation, options] {
    invocation.chosen = [&invocation, options] { return sweep_command(*options, invocation.stop); };
  });
}

}  // namespace coppice
