#include "coordinator/metrics/run_metrics.hpp"

#include <algorithm>
#include <spdlog/spdlog.h>
#include <utility>

#include "common/metrics/exposition.hpp"
#include "common/version.hpp"

namespace coppice {
namespace {

void add_dispatch(Exposition& out, const DispatchStatistics& statistics) {
  const auto total = [&](const char* name, const char* help, std::uint64_t value) {
    out.counter(name, help, static_cast<double>(value));
  };
  total("coppice_individuals_total", "Individuals that are settled.", statistics.individuals);
  total("coppice_individuals_repeated_total", "Of them, not evaluated because another meant the same.",
        statistics.repeated);
  total("coppice_individuals_at_home_total", "Of them, evaluated by the coordinator itself.", statistics.at_home);
  total("coppice_individuals_retried_total", "Units that were handed out again.", statistics.retried);
  total("coppice_individuals_apart_total", "Units computed in a process of their own, since workers died at them.",
        statistics.apart);
  total("coppice_individuals_checked_total", "Units that the coordinator computed again to check a worker.",
        statistics.cross_checked);
  total("coppice_batches_total", "Batches that were sent.", statistics.batches);
  total("coppice_batches_copied_total", "Of them, copies of what was late.", statistics.copies);
  total("coppice_batches_requeued_total", "Batches taken back from workers that died, hung, left or were late.",
        statistics.requeued);
  total("coppice_answers_duplicate_total", "Answers to what was settled already.", statistics.duplicates);
  total("coppice_samples_rejected_total", "Samples that did not decode, or belonged to nobody.", statistics.rejected);
  total("coppice_workers_lost_total", "Workers that died, hung or went out of reach.", statistics.workers_lost);
  total("coppice_workers_quarantined_total", "Workers that answered wrongly.", statistics.quarantined);
  total("coppice_workers_refused_total", "Workers of another protocol, or whose build computes otherwise.",
        statistics.refused);
  total("coppice_sent_bytes_total", "Payloads of tasks.", statistics.sent_bytes);
  total("coppice_received_bytes_total", "Payloads of answers.", statistics.received_bytes);
  out.counter("coppice_workers_busy_seconds_total", "Time that workers' lanes spent on answers, as they say.",
              static_cast<double>(statistics.busy_ns) / 1e9);
}

void add_fleet(Exposition& out, const FleetStatus& fleet) {
  out.counter("coppice_epochs_total", "Epochs of demes that ended.", static_cast<double>(fleet.epochs));
  const auto workers = [&](const char* state, std::size_t count) {
    out.gauge("coppice_workers", "Workers, by what they do.", static_cast<double>(count), {{"state", state}});
  };
  workers("joining", fleet.joining);
  workers("idle", fleet.idle);
  workers("evaluating", fleet.evaluating);
  out.gauge("coppice_worker_lanes_ready", "Evaluating threads of the workers that are ready.",
            static_cast<double>(fleet.lanes));
  out.gauge("coppice_worker_lanes_in_use", "Of them, those with a batch in hand.",
            static_cast<double>(fleet.lanes_busy));
  out.gauge("coppice_units_waiting", "Units (individuals, or epochs) that are out at nobody.",
            static_cast<double>(fleet.waiting));
  out.gauge("coppice_units_in_flight", "Units that are out at workers, copies included.",
            static_cast<double>(fleet.in_flight));
  out.gauge("coppice_requests_open", "Requests (generations, or epochs) that are under way.",
            static_cast<double>(fleet.requests));
  for (const auto& [source, record] : fleet.sources) {
    out.counter("coppice_source_rejected_total", "Samples that were rejected, by their source.",
                static_cast<double>(record.rejected), {{"source", source}});
  }
  for (const auto& [source, record] : fleet.sources) {
    out.counter("coppice_source_disagreeing_total", "Answers that differ from the truth, by their source.",
                static_cast<double>(record.disagreeing), {{"source", source}});
  }
}

}  // namespace

Result<std::shared_ptr<RunMetrics>> RunMetrics::open(const MetricsTargets& targets) {
  std::shared_ptr<RunMetrics> metrics(new RunMetrics());
  auto outlet = MetricsOutlet::open(targets, {.text = [raw = metrics.get()] { return raw->text(); }});
  if (!outlet) {
    return tl::unexpected(outlet.error());
  }
  metrics->outlet_ = std::move(*outlet);
  if (!targets.place.empty()) {
    spdlog::info("metrics at port {} (--metrics {})", metrics->outlet_->port(), targets.place);
  }
  return metrics;
}

void RunMetrics::fleet(const FleetStatus& status) {
  const std::lock_guard lock(mutex_);
  fleet_ = status;
  has_fleet_ = true;
}

void RunMetrics::statistics(const DispatchStatistics& statistics) {
  const std::lock_guard lock(mutex_);
  fleet_.statistics = statistics;
}

void RunMetrics::run_started(const std::string& run, std::uint32_t generations, std::uint32_t begin) {
  const std::lock_guard lock(mutex_);
  runs_[run].generations = generations;
  runs_[run].done = begin;
}

void RunMetrics::generation_done(const std::string& run, const GenerationRecord& record) {
  const std::lock_guard lock(mutex_);
  Run& known = runs_[run];
  if (known.last && record.generation <= known.last->generation) {  // a worker was found to lie: bred again
    ++known.rollbacks;
    known.last.reset();
  }
  known.best = known.last ? std::max(known.best, record.best.fitness) : record.best.fitness;
  known.done = record.generation + 1;
  known.evaluations += record.evaluations;
  known.last = record;
}

void RunMetrics::forget(const std::string& run) {
  const std::lock_guard lock(mutex_);
  runs_.erase(run);
}

void RunMetrics::runs(std::size_t ended, std::size_t all) {
  const std::lock_guard lock(mutex_);
  runs_ended_ = ended;
  runs_all_ = all;
}

std::string RunMetrics::text() const {
  Exposition out;
  out.gauge("coppice_info", "1; which build this is.", 1.0, {{"version", kVersion}});
  {
    const std::lock_guard lock(mutex_);
    add_dispatch(out, fleet_.statistics);
    if (has_fleet_) {
      add_fleet(out, fleet_);
    }
    for (const auto& [name, run] : runs_) {
      const Exposition::Labels labels = {{"run", name}};
      out.gauge("coppice_run_generations", "Generations that the run shall have.", run.generations, labels);
      out.gauge("coppice_run_generation", "Generations that are done.", run.done, labels);
      out.counter("coppice_run_evaluations_total", "Individuals evaluated for the run by this process.",
                  static_cast<double>(run.evaluations), labels);
      out.counter("coppice_run_rollbacks_total", "Times that the run went back, since a worker was found to lie.",
                  run.rollbacks, labels);
      if (run.last) {
        out.gauge("coppice_run_best_fitness", "Highest fitness of any generation so far.", run.best, labels);
        out.gauge("coppice_run_generation_best_fitness", "Highest fitness of the last generation.",
                  run.last->best.fitness, labels);
        out.gauge("coppice_run_generation_mean_fitness", "Mean fitness of the last generation.", run.last->mean_fitness,
                  labels);
        out.gauge("coppice_run_generation_seconds", "How long the last generation took.", run.last->seconds, labels);
      }
    }
    if (runs_all_ > 0) {
      out.gauge("coppice_sweep_runs", "Runs of the sweep.", static_cast<double>(runs_all_));
      out.gauge("coppice_sweep_runs_ended", "Runs of the sweep that ended.", static_cast<double>(runs_ended_));
    }
    for (const auto& [file, end] : fleet_.certificates) {
      out.gauge("coppice_certificate_end_seconds", "When a certificate of this identity ends, in Unix time.",
                static_cast<double>(end), {{"file", file}});
    }
  }
  add_process(out);
  return out.text();
}

}  // namespace coppice
