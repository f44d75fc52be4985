#include "coordinator/runs/sweep_in_folder.hpp"

#include <fmt/format.h>
#include <memory>
#include <optional>
#include <spdlog/spdlog.h>
#include <system_error>
#include <vector>

#include "coordinator/console/counted.hpp"
#include "coordinator/console/whole_file.hpp"
#include "coordinator/dispatch/serial_evaluator.hpp"
#include "coordinator/report/gnuplot.hpp"
#include "coordinator/report/interval_plot.hpp"
#include "coordinator/runs/evolve_with_rollback.hpp"
#include "coordinator/runs/learn_study.hpp"
#include "coordinator/runs/simulate_study.hpp"
#include "coordinator/sweep/journal.hpp"

namespace coppice {
namespace {

Result<void> prepare_folder(const SweepTask& task) {
  std::error_code error;
  if (std::filesystem::create_directory(task.folder, error)) {
    return {};
  }
  if (error) {
    return failed(fmt::format("cannot make the folder {}: {}", task.folder.string(), error.message()));
  }
  if (!task.resume) {
    return bad_input(fmt::format("-o: {} exists already: expected the name of a new folder, or --resume to go on in it",
                                 task.folder.string()));
  }
  return {};
}

Result<void> write_reports(const SweepTask& task, const SweepResults& results, const Study& study) {
  const Vocabulary& vocabulary = study.chain().vocabulary();
  if (const auto written = write_whole_file(task.folder / "settings.csv", settings_csv(task.plan, results)); !written) {
    return written;
  }
  if (const auto written = write_whole_file(task.folder / "runs.csv", runs_csv(task.plan, results, vocabulary));
      !written) {
    return written;
  }
  const auto plot = plot_of(task.plan, results, fmt::format("{}: means and 95 % intervals", study.path()));
  return plot ? write_plot(*plot, task.folder / "sweep.svg") : Result<void>();
}

class SweepInFolder {
 public:
  SweepInFolder(const Study& study, const SweepTask& task, const StopFlag& stop,
                const std::function<void(const SweepProgress&)>& progress)
      : study_(study),
        task_(task),
        stop_(stop),
        progress_(progress),
        chain_(std::make_shared<const Chain>(study.chain())),
        all_(task.plan.runs()) {}

  Result<SweepReport> run() {
    if (task_.plan.episodes > 0) {
      auto made = world_of(study_);
      if (!made) {
        return tl::unexpected(made.error());
      }
      world_ = std::move(*made);
    }
    if (auto ok = open_evaluators(); !ok) {
      return tl::unexpected(ok.error());
    }
    if (auto ok = prepare_folder(task_); !ok) {
      return tl::unexpected(ok.error());
    }
    const std::filesystem::path path = task_.folder / "runs.jsonl";
    auto journal = SweepJournal::open(path, study_.chain_hash(), task_.plan.episodes, chain_->vocabulary());
    if (!journal) {
      return tl::unexpected(journal.error());
    }
    if (const auto line = journal->line_beside(all_); line) {
      return bad_input(
          fmt::format("{}: line {} is a run that this sweep does not have: expected the study, --config and episodes "
                      "that the folder "
                      "was begun with, or a --config with more runs; or another -o",
                      path.string(), *line));
    }
    SweepReport report;
    report.outcome = run_missing(*journal, report);
    while (!report.outcome && report.outcome.error().kind == ErrorKind::revoked && report.rollbacks < kMostRollbacks) {
      ++report.rollbacks;
      report.outcome = begin_again(*journal, report);
    }
    report.at_home = pool_ != nullptr ? pool_->statistics().at_home : 0;
    if (auto ok = write_reports(task_, report.results, study_); !ok) {
      return tl::unexpected(ok.error());
    }
    return report;
  }

 private:
  bool serial() const { return task_.evaluator.kind == EvaluatorChoice::Kind::serial; }

  Result<void> open_evaluators() {
    if (serial()) {
      prepared_ = PreparedChain::make(chain_);
      return {};
    }
    pool_.reset();  // before its follower needs the same port
    auto opened = open_pool(chain_, task_.evaluator, stop_);
    if (!opened) {
      return tl::unexpected(opened.error());
    }
    pool_ = std::move(*opened);
    return {};
  }

  Result<void> begin_again(SweepJournal& journal, SweepReport& report) {
    const auto revoked = journal.revoke_added();
    if (!revoked) {
      return tl::unexpected(revoked.error());
    }
    spdlog::warn("rolling back: {} that ended while that worker served {} run again", counted(*revoked, "run"),
                 *revoked == 1 ? "is" : "are");
    if (auto ok = open_evaluators(); !ok) {
      return ok;
    }
    return run_missing(journal, report);
  }

  Result<void> run_missing(SweepJournal& journal, SweepReport& report) {
    report.results.assign(all_.size(), std::nullopt);
    std::vector<SweepRun> missing;
    std::vector<std::size_t> places;  // of the missing in all
    SweepProgress progress;
    for (std::size_t i = 0; i < all_.size(); ++i) {
      progress.generations += all_[i].config.ga.generations;
      if (const SweepResult* const known = journal.find(all_[i].config); known != nullptr) {
        report.results[i] = *known;
        progress.done += all_[i].config.ga.generations;
      } else {
        missing.push_back(all_[i]);
        places.push_back(i);
      }
    }
    progress.runs = all_.size();
    progress.ended = all_.size() - missing.size();
    SweepSettings settings;
    settings.at_once = task_.at_once;
    settings.new_evaluator = [this]() -> std::unique_ptr<Evaluator> {
      return serial() ? SerialEvaluator::make(prepared_, stop_) : pool_->client();
    };
    settings.episodes = task_.plan.episodes;
    settings.steps = world_ ? learned_steps(study_) : settings.steps;
    RunMetrics* const metrics = task_.evaluator.metrics.get();
    SweepHooks hooks;
    hooks.run_done = [&](std::size_t run, const SweepResult& result) {
      report.results[places[run]] = result;
      ++progress.ended;
      if (metrics != nullptr) {
        metrics->forget(std::to_string(places[run] + 1));
        metrics->runs(progress.ended, progress.runs);
      }
      return journal.add(missing[run].config, result);
    };
    hooks.generation_done = [&](std::size_t run, const GenerationRecord& record) {
      ++progress.done;
      if (metrics != nullptr) {
        const std::string name = std::to_string(places[run] + 1);
        metrics->run_started(name, missing[run].config.ga.generations, 0);
        metrics->generation_done(name, record);
      }
      progress.workers = pool_ != nullptr ? pool_->statistics().workers_alive : 0;
      progress_(progress);
    };
    progress_(progress);
    const Result<void> swept = sweep(*chain_, world_ ? &*world_ : nullptr, missing, settings, hooks, stop_);
    progress_(progress);
    return swept;
  }

  const Study& study_;
  const SweepTask& task_;
  const StopFlag& stop_;
  const std::function<void(const SweepProgress&)>& progress_;
  const std::shared_ptr<const Chain> chain_;
  const std::vector<SweepRun> all_;
  std::optional<World> world_;
  std::shared_ptr<const PreparedChain> prepared_;
  std::unique_ptr<EvaluatorPool> pool_;
};

}  // namespace

Result<SweepReport> sweep_in_folder(const Study& study, const SweepTask& task, const StopFlag& stop,
                                    const std::function<void(const SweepProgress&)>& progress) {
  return SweepInFolder(study, task, stop, progress).run();
}

}  // namespace coppice
