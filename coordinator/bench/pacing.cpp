#include "coordinator/bench/pacing.hpp"

#include <fmt/format.h>

#include "common/check.hpp"
#include "coordinator/bench/workload.hpp"
#include "coordinator/dispatch/serial_evaluator.hpp"
#include "coordinator/fleet/fleet_evaluator.hpp"

namespace coppice {
namespace {

struct Timed {
  double seconds = 0.0;
  double busy = 0.0;  // of a core: this process
};

// Times one generation. Errors also when its tallies are not the serial ones.
Result<Timed> time_generation(FleetEvaluator& evaluator, Evaluator& serial, const Workload& workload,
                              std::uint32_t generation) {
  const Job job = workload.job_of(generation);
  const auto expected = serial.evaluate(workload.trees, job);
  if (!expected) {
    return tl::unexpected(expected.error());
  }
  const Stopwatch watch;
  const auto got = evaluator.evaluate(workload.trees, job);
  const Timed timed{watch.seconds(), watch.processor_seconds() / watch.seconds()};
  if (!got) {
    return tl::unexpected(got.error());
  }
  if (*got != *expected) {
    return failed("paced workers gave other tallies than the serial path");
  }
  return timed;
}

Result<PacingRow> measure(const std::shared_ptr<const Chain>& chain, std::size_t workers, Evaluator& serial,
                          const PacingSettings& settings, const StopFlag& stop) {
  COPPICE_CHECK(settings.slow_workers <= workers);
  PacingRow row;
  row.workers = workers;
  row.individuals =
      settings.population != 0 ? settings.population : kIndividualsPerWorker * static_cast<std::uint32_t>(workers);
  row.ideal_seconds = row.individuals / paced_individuals_per_second(workers, settings);
  const Workload workload = light_workload(*chain, row.individuals);

  FleetOptions options;
  options.local_workers = workers;
  options.worker_program = settings.worker_program;
  options.worker_flags = paced_flags(workers, settings);
  const Stopwatch coming;
  auto evaluator = FleetEvaluator::open(chain, std::move(options), stop);
  if (!evaluator) {
    return tl::unexpected(evaluator.error());
  }
  if (auto ok = (*evaluator)->await_workers(workers); !ok) {
    return tl::unexpected(ok.error());
  }
  row.here_seconds = coming.seconds();

  const auto first = time_generation(**evaluator, serial, workload, 0);
  if (!first) {
    return tl::unexpected(first.error());
  }
  row.first_seconds = first->seconds;
  const DispatchStatistics before = (*evaluator)->statistics();
  std::vector<double> seconds;
  std::vector<double> busy;
  for (std::uint32_t generation = 1; generation <= settings.repetitions; ++generation) {
    const auto timed = time_generation(**evaluator, serial, workload, generation);
    if (!timed) {
      return tl::unexpected(timed.error());
    }
    seconds.push_back(timed->seconds);
    busy.push_back(timed->busy);
  }
  const DispatchStatistics after = (*evaluator)->statistics();
  row.seconds = spread_of(seconds);
  row.busy = spread_of(busy).median;
  row.efficiency = row.ideal_seconds / row.seconds.median;
  row.batches = static_cast<double>(after.batches - before.batches) / settings.repetitions;
  row.copies = static_cast<double>(after.copies - before.copies) / settings.repetitions;
  const Stopwatch going;
  evaluator->reset();
  row.gone_seconds = going.seconds();
  return row;
}

}  // namespace

std::vector<LocalWorkers::Flags> paced_flags(std::size_t workers, const PacingSettings& settings) {
  std::vector<LocalWorkers::Flags> flags;
  for (std::size_t i = 0; i < workers; ++i) {
    const auto pace = i < settings.slow_workers ? settings.slow_pace : settings.pace;
    flags.push_back({"--pace", fmt::format("{}ns", pace.count())});
  }
  return flags;
}

double paced_individuals_per_second(std::size_t workers, const PacingSettings& settings) {
  double per_second = 0.0;
  for (std::size_t i = 0; i < workers; ++i) {
    const auto pace = i < settings.slow_workers ? settings.slow_pace : settings.pace;
    per_second += 1e9 / static_cast<double>(pace.count());
  }
  return per_second;
}

Result<std::vector<PacingRow>> measure_pacing(const std::shared_ptr<const Chain>& chain, const PacingSettings& settings,
                                              const StopFlag& stop, const std::function<void(const PacingRow&)>& done) {
  COPPICE_CHECK(settings.pace.count() > 0);
  const auto serial = SerialEvaluator::make(chain, stop);
  if (!serial) {
    return tl::unexpected(serial.error());
  }
  std::vector<PacingRow> rows;
  for (const std::size_t workers : settings.workers) {
    const auto row = measure(chain, workers, **serial, settings, stop);
    if (!row) {
      return tl::unexpected(row.error());
    }
    done(*row);
    rows.push_back(*row);
  }
  return rows;
}

}  // namespace coppice
