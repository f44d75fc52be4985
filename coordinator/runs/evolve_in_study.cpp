#include "coordinator/runs/evolve_in_study.hpp"

#include <chrono>
#include <fmt/format.h>
#include <memory>
#include <utility>

#include "common/tree/simplify.hpp"
#include "common/tree/state_columns.hpp"
#include "coordinator/console/json_line.hpp"
#include "coordinator/runs/evolve_report.hpp"
#include "coordinator/runs/evolve_with_rollback.hpp"

namespace coppice {
namespace {

using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

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

// Records that the run failed, or was interrupted before its first generation; `best` is what it has come to so far.
tl::unexpected<Error> record_failure(Study& study, RunId run, const Error& error, const EvolveReport* best = nullptr) {
  RunOutcome outcome;
  if (best != nullptr) {
    outcome.tree = best->tree();
    outcome.pruned = best->pruned;
    if (const Result<void> saved = study.save_front(run, best->evolved.front); !saved) {
      return tl::unexpected(saved.error());
    }
  }
  outcome.status = error.kind == ErrorKind::interrupted ? RunStatus::interrupted : RunStatus::failed;
  outcome.json = json_line(Json{{"error", error.message}});
  const Result<void> finished = study.finish_run(run, outcome);
  if (!finished && finished.error().message == error.message) {  // the study itself is what failed
    return tl::unexpected(error);
  }
  return tl::unexpected(Error{
      error.kind, fmt::format("{}; {}", error.message, finished ? resume_hint(study) : finished.error().message)});
}

// Lets the tree that is worth most be the answer, where the configuration wants that.
Result<void> prefer(const Study& study, const StopFlag& stop, EvolveReport& report) {
  const Front& front = report.evolved.front;
  if (report.config.front.prefer == Prefer::pick || front.members.empty() || report.interrupted()) {
    return {};
  }
  auto answer = choose_answer(study, front, report.config, {.go_on = [&] { return !stop.raised(); }, .stop = &stop});
  if (!answer) {
    return tl::unexpected(answer.error());
  }
  const FrontMember& member = front.members[answer->member];
  Champion& best = report.evolved.best;
  best.tree = member.tree;
  best.fitness = member.fitness;
  best.agreement = value_of(front, member, measure_of(ObjectiveKind::agreement)).value_or(best.agreement);
  report.evolved.pick_fits = true;
  report.answer = std::move(*answer);
  return {};
}

}  // namespace

Result<EvolveReport> evolve_in_study(Study& study, const EvolveTask& task, const StopFlag& stop,
                                     const EvolveWatch& watch) {
  const auto chain = std::make_shared<const Chain>(study.chain());
  // Before the run exists: workers that cannot start leave no trace in the study.
  const Result<std::unique_ptr<Evaluator>> evaluator = open_evaluator(chain, task.evaluator, stop);
  if (!evaluator) {
    return tl::unexpected(evaluator.error());
  }
  Result<StartedRun> started = start_run(study, task);
  if (!started) {
    return tl::unexpected(std::move(started).error());
  }
  const RunId run = started->id;
  EvolveReport report;
  report.run = run;
  report.config = started->config;
  report.evaluator = task.evaluator;
  report.begin = started->checkpoint ? started->checkpoint->generation + 1 : 0;
  RunMetrics* const metrics = task.evaluator.metrics.get();
  const std::string name = fmt::format("{}#{}", study.path(), static_cast<std::int64_t>(run));
  if (metrics != nullptr) {
    metrics->run_started(name, started->config.ga.generations, report.begin);
  }
  const auto show = [&](const GenerationRecord& record) {
    const DispatchStatistics statistics = (*evaluator)->statistics();
    if (metrics != nullptr) {
      metrics->statistics(statistics);
      metrics->generation_done(name, record);
    }
    if (watch.generation_done) {
      watch.generation_done(record, statistics);
    }
  };
  if (watch.started) {
    watch.started(run, started->config.ga.generations, report.begin);
  }
  const Clock::time_point began = Clock::now();
  EvolveHooks hooks;
  // The records by deme of the epoch that generations_done reports next. One transaction saves both.
  std::vector<std::vector<GenerationRecord>> of_demes;
  hooks.demes_done = [&](std::span<const std::vector<GenerationRecord>> records) {
    of_demes.assign(records.begin(), records.end());
  };
  SavePace pace;
  hooks.due = [&pace] { return pace.due(); };
  hooks.generations_done = [&](std::span<const GenerationRecord> records,
                               const Checkpoint& checkpoint) -> Result<void> {
    const auto save = [&] { return study.save_generations(run, records, checkpoint, of_demes); };
    if (const Result<void> saved = pace.save(save); !saved) {
      return saved;
    }
    for (const GenerationRecord& record : records) {
      show(record);
    }
    return stop.raised() ? interrupted() : Result<void>();
  };
  auto [evolved, rollbacks] =
      evolve_with_rollback(study, run, started->config, started->checkpoint, **evaluator, hooks);
  report.seconds = std::chrono::duration<double>(Clock::now() - began).count();
  report.dispatch = (*evaluator)->statistics();
  report.rollbacks = rollbacks;
  if (!evolved) {
    return record_failure(study, run, evolved.error());
  }
  report.evolved = std::move(*evolved);
  const Vocabulary& vocabulary = chain->vocabulary();
  const auto prune_best = [&] {
    report.pruned = simplify(report.tree(), vocabulary, StateColumns(vocabulary, chain->parts().features)).tree;
  };
  if (auto chosen = prefer(study, stop, report); !chosen) {
    prune_best();  // the simulator failed, not the evolution: what it chose itself stays
    return record_failure(study, run, chosen.error(), &report);
  }
  prune_best();
  if (const Result<void> saved = study.save_front(run, report.evolved.front); !saved) {
    return tl::unexpected(saved.error());
  }
  const RunStatus status = report.interrupted() ? RunStatus::interrupted : RunStatus::finished;
  const Result<void> finished = study.finish_run(
      run, {.status = status, .tree = report.tree(), .pruned = report.pruned, .json = json_line(outcome_json(report))});
  if (!finished) {
    return tl::unexpected(finished.error());
  }
  return report;
}

std::string resume_hint(const Study& study) {
  return fmt::format("resume with: coppice evolve {} --resume", study.path());
}

}  // namespace coppice
