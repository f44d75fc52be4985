#include "coordinator/commands/evolve_progress.hpp"

#include <cstdio>
#include <fmt/format.h>

#include "coordinator/console/counted.hpp"

namespace coppice {
namespace {

std::string count_text(double count) {
  if (count >= 1e6) {
    return fmt::format("{:.1f}M", count / 1e6);
  }
  return count >= 1e4 ? fmt::format("{:.0f}k", count / 1e3) : fmt::format("{:.0f}", count);
}

std::string progress_text(const GenerationRecord& record, const DispatchStatistics& statistics,
                          EvaluatorChoice::Kind kind) {
  const double rate = record.seconds > 0.0 ? static_cast<double>(record.evaluations) / record.seconds : 0.0;
  std::string text =
      fmt::format("best {:.3f}, mean {:.3f}, {} (mean {:.0f}), {} evaluations/s", record.best.fitness,
                  record.mean_fitness, counted(record.best_nodes(), "node"), record.mean_nodes, count_text(rate));
  if (kind != EvaluatorChoice::Kind::serial) {
    text += ", " + counted(statistics.workers_alive, "worker");
    if (statistics.epochs_open > 0) {
      text += statistics.fewest_held == statistics.most_held
                  ? fmt::format(" with {} each", counted(statistics.most_held, "epoch"))
                  : fmt::format(" with {} to {} each", statistics.fewest_held, counted(statistics.most_held, "epoch"));
    }
  }
  return text;
}

}  // namespace

EvolveWatch EvolveProgress::watch() {
  return {.started =
              [this](RunId, std::uint32_t generations, std::uint32_t begin) {
                ProgressSettings settings = progress_settings_for(stderr);
                settings.plain_every_done = lines_every_;
                progress_.emplace(stderr, settings, "evolve", "generations", generations, begin);
              },
          .generation_done =
              [this](const GenerationRecord& record, const DispatchStatistics& statistics) {
                progress_->update(record.generation + 1, progress_text(record, statistics, kind_));
              }};
}

void EvolveProgress::finish(const EvolveReport& report) {
  progress_->finish(report.evolved.generations_done,
                    fmt::format("best {:.4f}, {}", report.evolved.best.fitness, counted(report.tree().size(), "node")));
}

Result<EvolveReport> evolve_shown(Study& study, const EvolveTask& task, std::uint32_t lines_every,
                                  const StopFlag& stop) {
  EvolveProgress progress(task.evaluator.kind, lines_every);
  Result<EvolveReport> report = evolve_in_study(study, task, stop, progress.watch());
  if (report) {
    progress.finish(*report);
  }
  return report;
}

}  // namespace coppice
