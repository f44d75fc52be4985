#include "coordinator/commands/evolve_options.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <fmt/format.h>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "common/tree/simplify.hpp"
#include "common/tree/state_columns.hpp"
#include "common/tree/text.hpp"
#include "coordinator/commands/evaluator_option.hpp"
#include "coordinator/commands/honest_evolution.hpp"
#include "coordinator/commands/whole_number.hpp"
#include "coordinator/evolution/evolve.hpp"
#include "coordinator/report/counted.hpp"
#include "coordinator/report/json_line.hpp"
#include "coordinator/report/progress.hpp"

namespace coppice {
namespace {

using Json = nlohmann::ordered_json;

std::string count_text(double count) {
  if (count >= 1e6) {
    return fmt::format("{:.1f}M", count / 1e6);
  }
  return count >= 1e4 ? fmt::format("{:.0f}k", count / 1e3) : fmt::format("{:.0f}", count);
}

std::string progress_text(const GenerationRecord& record, const DispatchStatistics& statistics, bool serial) {
  const double rate = record.seconds > 0.0 ? static_cast<double>(record.evaluations) / record.seconds : 0.0;
  std::string text =
      fmt::format("best {:.3f}, mean {:.3f}, {} (mean {:.0f}), {} evaluations/s", record.best.fitness,
                  record.mean_fitness, counted(record.best_nodes(), "node"), record.mean_nodes, count_text(rate));
  if (!serial) {
    text += fmt::format(", {} worker{}", statistics.workers_alive, statistics.workers_alive == 1 ? "" : "s");
  }
  return text;
}

// What workers that lied have to do with the result.
struct Trust {
  std::uint32_t fresh_starts = 0;
  std::uint32_t begin = 0;  // generations that another process did
  bool quarantined = false;

  // Of the first generations, so many may hold what a worker said that this process found out.
  std::uint32_t suspect() const { return quarantined ? begin : 0; }
};

std::string in_words(const Trust& trust) {
  std::string text;
  if (trust.fresh_starts > 0) {
    text +=
        fmt::format("begun again {} from generation {}, because a worker had answered wrongly: the result is honest\n",
                    counted(trust.fresh_starts, "time"), trust.begin + 1);
  }
  if (trust.suspect() > 0) {
    text += fmt::format(
        "suspect: generations 1 to {} were done before this run was resumed, perhaps with the worker that was "
        "quarantined now; to be sure, begin the run anew with the same settings and seed\n",
        trust.suspect());
  }
  return text;
}

Json json_of(const DispatchStatistics& statistics, const Trust& trust) {
  return {{"individuals", statistics.individuals},   {"repeated", statistics.repeated},
          {"batches", statistics.batches},           {"duplicates", statistics.duplicates},
          {"requeued", statistics.requeued},         {"rejected", statistics.rejected},
          {"workers_lost", statistics.workers_lost}, {"cross_checked", statistics.cross_checked},
          {"quarantined", statistics.quarantined},   {"begun_again", trust.fresh_starts},
          {"suspect_generations", trust.suspect()}};
}

// The run's figures; what a repetition with the same seed repeats, but for seconds and dispatch.
Json outcome_json(const Evolved& evolved, const DispatchStatistics& statistics, const Trust& trust, double seconds) {
  return {{"fitness", evolved.best.fitness},         {"agreement", evolved.best.agreement},
          {"final_steps", evolved.final_steps},      {"best_generation", evolved.best.generation},
          {"generations", evolved.generations_done}, {"seconds", seconds},
          {"dispatch", json_of(statistics, trust)}};
}

// Of what the answer's agreement is a share.
std::string measured_on(const Evolved& evolved, const RolloutConfig& rollout) {
  const bool last_only = rollout.method == Method::rollouts && !evolved.interrupted;
  switch (last_only ? rollout.final_method : rollout.method) {
    case Method::rollouts:
      break;
    case Method::exact:
      return fmt::format("{}, exactly", counted(rollout.steps, "step"));
    case Method::discounted:
      return fmt::format("an endless walk discounted by {}, exactly", rollout.gamma);
    case Method::long_run:
      return "an endless walk, exactly";
  }
  return evolved.interrupted ? "its generation's steps" : fmt::format("{} steps", evolved.final_steps);
}

struct StartedRun {
  RunId id{};
  EvolveConfig config;
  std::optional<Checkpoint> checkpoint;
};

Result<StartedRun> start_run(Study& study, const EvolveTask& task) {
  if (task.resumed) {
    Result<ResumedRun> resumed = study.resume_run(*task.resumed, task.take_over);
    if (!resumed) {
      return tl::unexpected(std::move(resumed).error());
    }
    return StartedRun{*task.resumed, std::move(resumed->config), std::move(resumed->checkpoint)};
  }
  const Result<RunId> id = study.begin_run({task.config, in_words(task.evaluator)});
  if (!id) {
    return tl::unexpected(id.error());
  }
  return StartedRun{*id, task.config, std::nullopt};
}

// Where a configuration comes from that is wrong as a whole.
std::string given_by(const EvolveOptions& options) {
  if (options.settings.empty()) {
    return options.config_file;
  }
  const std::string settings = fmt::format("--set {}", fmt::join(options.settings, " --set "));
  return options.config_file.empty() ? settings : fmt::format("{} with {}", options.config_file, settings);
}

}  // namespace

void add_evolve_options(CLI::App& command, EvolveOptions& options) {
  command.add_option("--config", options.config_file, "Configuration; keys that it leaves out are as in the thesis")
      ->type_name("FILE.toml");
  command.add_option("--set", options.settings, "Change one key, after --config; may be repeated")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  command
      .add_option("--lines-every", options.lines_every,
                  "Generations between progress lines when standard error is no terminal")
      ->type_name("N")
      ->check(whole_number())
      ->capture_default_str();
}

Result<EvolveConfig> evolve_config(const EvolveOptions& options, std::optional<std::uint64_t> seed,
                                   const Vocabulary& vocabulary) {
  EvolveConfig config;
  if (!options.config_file.empty()) {
    if (const Result<void> loaded = load_config(options.config_file, config); !loaded) {
      return tl::unexpected(loaded.error());
    }
  }
  for (const std::string& setting : options.settings) {
    if (const Result<void> applied = apply_setting(setting, config); !applied) {
      return tl::unexpected(applied.error());
    }
  }
  config.seed = seed.value_or(config.seed);
  if (const Result<void> checked = check_config(config, vocabulary); !checked) {
    const std::string place = given_by(options);
    return place.empty() ? tl::unexpected(checked.error()) : in_context(place, checked.error());
  }
  return config;
}

Result<EvolveReport> evolve_in_study(Study& study, const EvolveTask& task, const StopFlag& stop) {
  const auto chain = std::make_shared<const Chain>(study.chain());
  bool taken_back = false;
  EvaluatorChoice choice = task.evaluator;
  choice.taken_back = [&taken_back] { taken_back = true; };
  // Before the run exists: workers that cannot start leave no trace in the study.
  const Result<std::unique_ptr<Evaluator>> evaluator = open_evaluator(chain, choice, stop);
  if (!evaluator) {
    return tl::unexpected(evaluator.error());
  }
  Result<StartedRun> started = start_run(study, task);
  if (!started) {
    return tl::unexpected(std::move(started).error());
  }
  const RunId run = started->id;
  const std::uint32_t begin = started->checkpoint ? started->checkpoint->generation + 1 : 0;
  const bool serial = task.evaluator.kind == EvaluatorChoice::Kind::serial;

  ProgressSettings settings = progress_settings_for(stderr);
  settings.plain_every_done = task.lines_every;
  Progress progress(stderr, settings, "evolve", "generations", started->config.ga.generations, begin);
  const Clock::time_point began = Clock::now();
  EvolveHooks hooks;
  hooks.generation_done = [&](const GenerationRecord& record, const Checkpoint& checkpoint) -> Result<void> {
    if (const Result<void> saved = study.save_generation(run, record, checkpoint); !saved) {
      return saved;
    }
    progress.update(record.generation + 1, progress_text(record, (*evaluator)->statistics(), serial));
    if (stop.raised()) {
      return interrupted();
    }
    return {};
  };
  const auto [evolved, fresh_starts] =
      evolve_honestly(study, run, started->config, started->checkpoint, **evaluator, taken_back, hooks);
  const double seconds = std::chrono::duration<double>(Clock::now() - began).count();
  const DispatchStatistics statistics = (*evaluator)->statistics();
  if (!evolved) {
    RunOutcome outcome;
    outcome.status = evolved.error().kind == ErrorKind::interrupted ? RunStatus::interrupted : RunStatus::failed;
    outcome.json = json_line(Json{{"error", evolved.error().message}});
    const Result<void> finished = study.finish_run(run, outcome);
    const std::string& why = evolved.error().message;
    if (!finished && finished.error().message == why) {  // the study itself is what failed
      return tl::unexpected(evolved.error());
    }
    return tl::unexpected(Error{evolved.error().kind,
                                fmt::format("{}; {}", why, finished ? resume_hint(study) : finished.error().message)});
  }
  progress.finish(evolved->generations_done,
                  fmt::format("best {:.4f}, {}", evolved->best.fitness, counted(evolved->best.tree.size(), "node")));

  const Vocabulary& vocabulary = chain->vocabulary();
  const Tree pruned = simplify(evolved->best.tree, vocabulary, StateColumns(vocabulary, chain->parts().features)).tree;
  const RunStatus status = evolved->interrupted ? RunStatus::interrupted : RunStatus::finished;
  const Trust trust{fresh_starts, begin, statistics.quarantined > 0};
  const Json outcome = outcome_json(*evolved, statistics, trust, seconds);
  if (const Result<void> saved = study.save_front(run, evolved->front); !saved) {
    return tl::unexpected(saved.error());
  }
  const Result<void> finished = study.finish_run(
      run, {.status = status, .tree = evolved->best.tree, .pruned = pruned, .json = json_line(outcome)});
  if (!finished) {
    return tl::unexpected(finished.error());
  }
  const std::string tree_text = to_text(evolved->best.tree, vocabulary);
  const std::string pruned_text = to_text(pruned, vocabulary);
  std::string text = fmt::format("run {}: {}, seed {}, {}, {:.1f} s\n", static_cast<std::int64_t>(run),
                                 counted(evolved->generations_done, "generation"), started->config.seed,
                                 in_words(task.evaluator), seconds);
  text += fmt::format("fitness {:.4f}, agreement {:.1f} % of {}\n", evolved->best.fitness,
                      100.0 * evolved->best.agreement, measured_on(*evolved, started->config.rollout));
  text += fmt::format("{} individuals, {:.0f} % of them the same in every state as another of their generation\n",
                      statistics.individuals,
                      100.0 * static_cast<double>(statistics.repeated) /
                          static_cast<double>(std::max<std::uint64_t>(1, statistics.individuals)));
  text += in_words(trust);
  text += fmt::format("evolved, {}:\n{}\n", counted(evolved->best.tree.size(), "node"), tree_text);
  text += fmt::format("pruned, {}:\n{}\n", counted(pruned.size(), "node"), pruned_text);
  if (!evolved->front.members.empty()) {
    text += fmt::format("front: {} (coppice front {})\n", counted(evolved->front.members.size(), "tree"), study.path());
  }
  if (!evolved->pick_fits) {
    text += fmt::format("no tree of the front fits front.pick '{}': this is the one of the highest fitness\n",
                        started->config.front.pick);
  }
  Json json = {{"study", study.path()},
               {"run", static_cast<std::int64_t>(run)},
               {"status", name_of(status)},
               {"evaluator", in_words(task.evaluator)},
               {"seed", started->config.seed}};
  json.update(outcome);
  if (!evolved->front.members.empty()) {
    json["front"] = evolved->front.members.size();
    json["pick_fits"] = evolved->pick_fits;
  }
  json["tree"] = tree_text;
  json["nodes"] = evolved->best.tree.size();
  json["pruned"] = pruned_text;
  json["pruned_nodes"] = pruned.size();
  return EvolveReport{.run = run,
                      .tree = evolved->best.tree,
                      .pruned = pruned,
                      .interrupted = evolved->interrupted,
                      .text = std::move(text),
                      .json = json_line(json)};
}

std::string resume_hint(const Study& study) {
  return fmt::format("resume with: coppice evolve {} --resume", study.path());
}

}  // namespace coppice
