#include <CLI/CLI.hpp>
#include <charconv>
#include <cstdio>
#include <fmt/format.h>
#include <memory>
#include <optional>

#include "coordinator/commands/commands.hpp"
#include "coordinator/commands/evaluator_option.hpp"
#include "coordinator/commands/evolve_options.hpp"
#include "coordinator/commands/evolve_progress.hpp"
#include "coordinator/commands/shared_flags.hpp"
#include "coordinator/runs/evolve_report.hpp"
#include "coordinator/runs/simulate_study.hpp"

namespace coppice {
namespace {

struct EvolveFlags {
  std::string study;
  EvolveOptions evolution;
  EvaluatorOption evaluator;
  std::optional<std::uint64_t> seed;
  std::string resume;  // "last", or a number
  bool take_over = false;
  std::optional<std::int64_t> run;
  bool json = false;
};

// The run asked for, or the last that did not reach its end; whether it can go on, resume_run() finds out.
Result<RunId> run_to_resume(const Study& study, std::optional<std::int64_t> wanted) {
  if (wanted) {
    return RunId{*wanted};
  }
  const Result<std::vector<RunRecord>> runs = study.runs();
  if (!runs) {
    return tl::unexpected(runs.error());
  }
  for (auto run = runs->rbegin(); run != runs->rend(); ++run) {
    if (run->status != RunStatus::finished) {
      return run->id;
    }
  }
  return bad_input(fmt::format("{}: has no unfinished run: nothing to resume", study.path()));
}

// By --resume=RUN or --run RUN; none: the last.
Result<std::optional<std::int64_t>> run_wanted(const EvolveFlags& options) {
  if (options.resume == "last") {
    return options.run;
  }
  std::int64_t run = 0;
  const char* const end = options.resume.data() + options.resume.size();
  const auto parsed = std::from_chars(options.resume.data(), end, run);
  if (parsed.ec != std::errc{} || parsed.ptr != end || run < 1 || options.run.value_or(run) != run) {
    return bad_input(
        fmt::format("--resume={}: expected the number of one run, as coppice info shows it", options.resume));
  }
  return std::optional<std::int64_t>(run);
}

Result<void> evolve_command(const EvolveFlags& options, const StopFlag& stop) {
  const Result<EvaluatorChoice> evaluator = evaluator_choice(options.evaluator);
  if (!evaluator) {
    return tl::unexpected(evaluator.error());
  }
  Result<Study> study = Study::open(options.study);
  if (!study) {
    return tl::unexpected(study.error());
  }
  EvolveTask task;
  task.evaluator = *evaluator;
  if (!options.resume.empty()) {
    const Result<std::optional<std::int64_t>> wanted = run_wanted(options);
    if (!wanted) {
      return tl::unexpected(wanted.error());
    }
    const Result<RunId> run = run_to_resume(*study, *wanted);
    if (!run) {
      return tl::unexpected(run.error());
    }
    task.resumed = *run;
    task.take_over = options.take_over;
  } else {
    Result<EvolveConfig> config = evolve_config(options.evolution, options.seed,
                                                {.vocabulary = study->chain().vocabulary(),
                                                 .discount = study->problem().discount,
                                                 .simulated = has_simulator(*study)});
    if (!config) {
      return tl::unexpected(config.error());
    }
    task.config = std::move(*config);
  }
  const Result<EvolveReport> report = evolve_shown(*study, task, options.evolution.lines_every, stop);
  if (!report) {
    return tl::unexpected(report.error());
  }
  fmt::print("{}{}", options.json ? to_json(*report, *study) : to_text(*report, *study), options.json ? "\n" : "");
  if (report->interrupted()) {
    return tl::unexpected(Error{ErrorKind::interrupted, fmt::format("interrupted; {}", resume_hint(*study))});
  }
  return {};
}

}  // namespace

void add_evolve(CLI::App& app, Invocation& invocation) {
  const auto options = std::make_shared<EvolveFlags>();
  CLI::App* command = app.add_subcommand("evolve", "Breed behaviour trees that do what the policy does");
  add_study_argument(*command, options->study, "The study file; the run is kept in it");
  add_evaluator_option(*command, options->evaluator);
  add_evolve_options(*command, options->evolution);
  CLI::Option* seed = add_seed_option(*command, options->seed, "Same seed, same result (default: seed of --config)");
  CLI::Option* resume =
      command->add_flag("--resume{last}", options->resume,
                        "Go on with the last unfinished run, by its own configuration; --resume=RUN with that one");
  resume->excludes(command->get_option("--config"))->excludes(command->get_option("--set"))->excludes(seed);
  add_run_option(*command, options->run, "With --resume: this run instead of the last unfinished one")->needs(resume);
  command
      ->add_flag("--take-over", options->take_over,
                 "With --resume: even a run of another host, where it may still be running")
      ->needs(resume);
  add_json_flag(*command, options->json);
  command->footer(
      "Ctrl-C keeps the best so far (exit code 4); --resume goes on to the very same result.\n"
      "Examples:\n"
      "  coppice evolve uav.coppice --workers 2\n"
      "  coppice evolve uav.coppice --serial --set ga.population=200 --set fitness.coverage=0.5 --seed 3\n"
      "  coppice evolve uav.coppice --resume=2");
  command->callback([&invocation, options] {
    invocation.chosen = [&invocation, options] { return evolve_command(*options, invocation.stop); };
  });
}

}  // namespace coppice
