#include "coordinator/bench/paced_demes.hpp"

#include <algorithm>
#include <optional>

#include "common/check.hpp"
#include "coordinator/bench/demes.hpp"
#include "coordinator/dispatch/serial_evaluator.hpp"
#include "coordinator/evolution/evolve.hpp"
#include "coordinator/fleet/fleet_evaluator.hpp"

namespace coppice {
namespace {

EvolveConfig paced_config(std::uint32_t demes) {
  EvolveConfig config;
  config.ga.demes = demes;
  config.ga.population = demes * kPacedDemeSize;
  config.ga.epoch = kPacedEpoch;
  config.ga.generations = kPacedEpoch * kPacedEpochs;
  config.ga.migrants = 2;
  config.ga.tournament = 3.0 / config.ga.population;
  config.rollout.final_rollouts = config.rollout.rollouts;
  return config;
}

struct TimedEpochs {
  double seconds = 0.0;  // of the epochs
  double busy = 0.0;     // processor seconds of this process meanwhile
};

Result<TimedEpochs> time_run(const Chain& chain, const EvolveConfig& config, Evaluator& fleet, Evaluator& serial) {
  const auto expected = evolve(chain, config, serial, std::nullopt, {});
  if (!expected) {
    return tl::unexpected(expected.error());
  }
  TimedEpochs timed;
  const Stopwatch watch;
  EvolveHooks hooks;
  hooks.generations_done = [&](std::span<const GenerationRecord>, const Checkpoint&) -> Result<void> {
    timed = {watch.seconds(), watch.processor_seconds()};
    return {};
  };
  const auto evolved = evolve(chain, config, fleet, std::nullopt, hooks);
  if (!evolved) {
    return tl::unexpected(evolved.error());
  }
  if (evolved->interrupted || expected->interrupted) {
    return interrupted();
  }
  if (*evolved != *expected) {
    return failed("demes on paced workers ended otherwise than the serial run");
  }
  return timed;
}

Result<PacedDemesRow> measure_team(const std::shared_ptr<const Chain>& chain, std::size_t workers, Evaluator& serial,
                                   const PacingSettings& settings, const StopFlag& stop) {
  COPPICE_CHECK(settings.slow_workers <= workers);
  PacedDemesRow row;
  row.workers = workers;
  row.demes = settings.population == 0 ? static_cast<std::uint32_t>(workers) : settings.population / kPacedDemeSize;
  row.demes = std::max(row.demes, 2U);  // one alone is no run in demes
  EvolveConfig config = paced_config(row.demes);
  row.epochs = row.demes * kPacedEpochs;
  row.ideal_seconds = row.epochs * double{kPacedIndividualsPerEpoch} / paced_individuals_per_second(workers, settings);
  FleetOptions options;
  options.local_workers = workers;
  options.worker_program = settings.worker_program;
  options.worker_flags = paced_flags(workers, settings);
  auto fleet = FleetEvaluator::open(chain, std::move(options), stop);
  if (!fleet) {
    return tl::unexpected(fleet.error());
  }
  if (auto ok = (*fleet)->await_workers(workers); !ok) {
    return tl::unexpected(ok.error());
  }
  std::vector<double> seconds;
  std::vector<double> busy;
  std::uint64_t copies = 0;
  for (std::uint32_t repetition = 0; repetition < settings.repetitions; ++repetition) {
    config.seed = repetition + 1;
    const std::uint64_t before = (*fleet)->statistics().copies;
    const auto timed = time_run(*chain, config, **fleet, serial);
    if (!timed) {
      return tl::unexpected(timed.error());
    }
    seconds.push_back(timed->seconds);
    busy.push_back(timed->busy / timed->seconds);
    copies += (*fleet)->statistics().copies - before;
  }
  row.seconds = spread_of(seconds);
  row.busy = spread_of(busy).median;
  row.copies = static_cast<double>(copies) / settings.repetitions;
  return row;
}

}  // namespace

Result<std::vector<PacedDemesRow>> measure_paced_demes(const std::shared_ptr<const Chain>& chain,
                                                       const PacingSettings& settings, const StopFlag& stop,
                                                       const std::function<void(const PacedDemesRow&)>& done) {
  COPPICE_CHECK(settings.pace.count() > 0);
  const auto serial = SerialEvaluator::make(chain, stop);
  if (!serial) {
    return tl::unexpected(serial.error());
  }
  const double epoch = static_cast<double>(settings.pace.count()) * 1e-9 * kPacedIndividualsPerEpoch;
  std::optional<EpochCosts> costs;
  std::vector<PacedDemesRow> rows;
  for (const std::size_t workers : settings.workers) {
    auto row = measure_team(chain, workers, **serial, settings, stop);
    if (!row) {
      return tl::unexpected(row.error());
    }
    if (costs) {
      row->predicted_seconds =
          row->epochs * epoch / predicted_speed_up(*costs, row->demes, static_cast<double>(workers));
    } else if (settings.slow_workers == 0) {
      const double lanes = std::min<double>(static_cast<double>(workers), row->demes);
      costs = {epoch, std::max(0.0, row->seconds.median * lanes / row->epochs - epoch),
               row->busy * row->seconds.median / row->epochs};
    }
    done(*row);
    rows.push_back(*row);
  }
  return rows;
}

}  // namespace coppice
