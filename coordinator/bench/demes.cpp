#include "coordinator/bench/demes.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <thread>

#include "common/check.hpp"
#include "common/evolution/migration.hpp"
#include "coordinator/console/counted.hpp"
#include "coordinator/dispatch/serial_evaluator.hpp"
#include "coordinator/evolution/evolve.hpp"
#include "coordinator/fleet/fleet_evaluator.hpp"

namespace coppice {
namespace {

constexpr std::uint32_t kDemes = 8;
constexpr std::uint32_t kGenerations = 60;

// One way to run a workload.
struct Runner {
  std::string name;
  std::size_t lanes = 1;
  std::unique_ptr<Evaluator> evaluator;
  bool workers = false;
  std::vector<double> seconds = {};
  std::vector<double> speed_up = {};
  std::vector<double> busy = {};  // processor seconds
  std::uint64_t bytes = 0;
};

Result<std::vector<Runner>> runners_of(const std::shared_ptr<const Chain>& chain, const ScalingSettings& settings,
                                       const StopFlag& stop) {
  std::vector<Runner> runners;
  for (const Team& team : settings.teams) {
    if (team.lanes() > 1) {
      auto threads = SerialEvaluator::make(chain, stop, team.lanes());
      if (!threads) {
        return tl::unexpected(threads.error());
      }
      runners.push_back(
          {.name = counted(team.lanes(), "thread"), .lanes = team.lanes(), .evaluator = std::move(*threads)});
    }
    FleetOptions options;
    options.local_workers = team.workers;
    options.worker_program = settings.worker_program;
    options.worker_threads = team.threads;
    auto fleet = FleetEvaluator::open(chain, std::move(options), stop);
    if (!fleet) {
      return tl::unexpected(fleet.error());
    }
    if (auto ok = (*fleet)->await_workers(team.workers); !ok) {
      return tl::unexpected(ok.error());
    }
    runners.push_back({.name = team.name(), .lanes = team.lanes(), .evaluator = std::move(*fleet), .workers = true});
  }
  return runners;
}

std::uint64_t traffic_of(const Evaluator& evaluator) {
  const DispatchStatistics statistics = evaluator.statistics();
  return statistics.sent_bytes + statistics.received_bytes;
}

class DemeMeasurement {
 public:
  DemeMeasurement(const std::shared_ptr<const Chain>& chain, const DemeWorkload& workload,
                  const ScalingSettings& settings, const StopFlag& stop, std::vector<Runner>& runners)
      : chain_(chain),
        workload_(workload),
        config_(workload.config),
        settings_(settings),
        stop_(stop),
        runners_(runners) {}

  Result<DemeScaling> run() {
    for (Runner& runner : runners_) {
      runner.seconds.clear();
      runner.speed_up.clear();
      runner.busy.clear();
      runner.bytes = 0;
    }
    // The first repetition warms everything up and is not counted.
    for (std::uint32_t repetition = 0; repetition <= settings_.repetitions; ++repetition) {
      // Each with a seed of its own: who has seen a sample before knows what the trees are worth.
      config_.seed = workload_.config.seed + repetition;
      if (auto ok = repeat(repetition > 0); !ok) {
        return tl::unexpected(ok.error());
      }
    }
    return result();
  }

 private:
  Result<Evolved> evolve_on(Evaluator& evaluator) const {
    auto evolved = evolve(*chain_, config_, evaluator, std::nullopt, {});
    if (evolved && evolved->interrupted) {
      return interrupted();
    }
    return evolved;
  }

  Result<void> repeat(bool counts) {
    auto serial = SerialEvaluator::make(chain_, stop_);
    const Stopwatch watch;
    const auto expected = evolve_on(**serial);
    const double seconds = watch.seconds();
    if (!expected) {
      return tl::unexpected(expected.error());
    }
    const double abreast = run_abreast();
    if (counts) {
      serial_seconds_.push_back(seconds);
      abreast_speed_up_.push_back(seconds * static_cast<double>(abreast_) / abreast);
    }
    for (Runner& runner : runners_) {
      const std::uint64_t before = traffic_of(*runner.evaluator);
      const Stopwatch own;
      const auto evolved = evolve_on(*runner.evaluator);
      const double took = own.seconds();
      const double busy = own.processor_seconds();
      if (!evolved) {
        return tl::unexpected(evolved.error());
      }
      if (*evolved != *expected) {
        return failed(
            fmt::format("demes of '{}': {} ended otherwise than the serial run", workload_.name, runner.name));
      }
      if (counts) {
        runner.seconds.push_back(took);
        runner.speed_up.push_back(seconds / took);
        runner.busy.push_back(busy);
        runner.bytes += traffic_of(*runner.evaluator) - before;
      }
    }
    return {};
  }

  double run_abreast() {
    const Stopwatch watch;
    std::vector<std::thread> threads;
    threads.reserve(abreast_);
    for (std::size_t i = 0; i < abreast_; ++i) {
      threads.emplace_back([this] {
        auto serial = SerialEvaluator::make(chain_, stop_);
        static_cast<void>(evolve_on(**serial));
      });
    }
    for (std::thread& thread : threads) {
      thread.join();
    }
    return watch.seconds();
  }

  DemeScaling result() const {
    const GaConfig& ga = workload_.config.ga;
    DemeScaling scaling;
    scaling.name = workload_.name;
    scaling.demes = ga.demes;
    scaling.epochs = std::uint64_t{epochs_of(ga)} * ga.demes;
    scaling.individuals = std::uint64_t{ga.generations} * ga.population;
    scaling.serial_seconds = spread_of(serial_seconds_);
    scaling.abreast = abreast_;
    scaling.abreast_speed_up = spread_of(abreast_speed_up_);
    for (const Runner& runner : runners_) {
      DemeRow row;
      row.name = runner.name;
      row.lanes = runner.lanes;
      row.seconds = spread_of(runner.seconds);
      row.speed_up = spread_of(runner.speed_up);
      if (runner.workers) {
        row.bytes =
            static_cast<double>(runner.bytes) / settings_.repetitions / static_cast<double>(scaling.individuals);
        row.busy = spread_of(runner.busy).median / static_cast<double>(scaling.epochs);
      }
      scaling.rows.push_back(std::move(row));
    }
    return scaling;
  }

  const std::shared_ptr<const Chain>& chain_;
  const DemeWorkload& workload_;
  EvolveConfig config_;  // of the repetition
  const ScalingSettings& settings_;
  const StopFlag& stop_;
  std::vector<Runner>& runners_;
  const std::size_t abreast_ = std::max<std::size_t>(settings_.cores, 1);
  std::vector<double> serial_seconds_;
  std::vector<double> abreast_speed_up_;
};

}  // namespace

std::vector<DemeWorkload> deme_workloads() {
  EvolveConfig thesis;
  thesis.ga.generations = kGenerations;
  thesis.ga.demes = kDemes;
  thesis.ga.population = 100 * kDemes;
  thesis.ga.tournament = 0.01;  // 8 of 100
  EvolveConfig front = thesis;
  front.ga.search = Search::front;
  front.ga.crossover = 0.4;
  front.ga.mutation = 0.8;
  front.ga.edits = 0.8;
  front.ga.local_search = 0.4;
  front.ga.max_depth = 8;
  front.ga.max_children = 12;
  front.ga.max_nodes = 20;
  front.ga.seeding = Seeding::greedy;
  front.rollout.rollouts = 20;
  front.rollout.steps = 150;
  front.front.members = 300;
  front.front.objectives = {measure_of(ObjectiveKind::agreement), measure_of(ObjectiveKind::coverage),
                            measure_of(ObjectiveKind::expected_return), measure_of(ObjectiveKind::collisions),
                            measure_of(ObjectiveKind::unknown)};
  return {{"thesis", thesis}, {"front", front}};
}

Result<std::vector<DemeScaling>> measure_demes(const std::shared_ptr<const Chain>& chain,
                                               const std::vector<DemeWorkload>& workloads,
                                               const ScalingSettings& settings, const StopFlag& stop,
                                               const std::function<void(const DemeScaling&)>& done) {
  auto runners = runners_of(chain, settings, stop);
  if (!runners) {
    return tl::unexpected(runners.error());
  }
  std::vector<DemeScaling> all;
  for (const DemeWorkload& workload : workloads) {
    auto scaling = DemeMeasurement(chain, workload, settings, stop, *runners).run();
    if (!scaling) {
      return tl::unexpected(scaling.error());
    }
    done(*scaling);
    all.push_back(std::move(*scaling));
  }
  return all;
}

double predicted_speed_up(const EpochCosts& costs, std::uint32_t demes, double lanes) {
  const double used = std::min(static_cast<double>(demes), lanes);
  return std::min(used * costs.core / (costs.core + costs.lost), costs.core / std::max(costs.coordinator, 1e-9));
}

DemePlan plan_of(const DemeScaling& scaling, const Hosts& hosts) {
  const auto row = std::find_if(scaling.rows.rbegin(), scaling.rows.rend(),
                                [](const DemeRow& candidate) { return candidate.bytes > 0.0; });
  COPPICE_CHECK(row != scaling.rows.rend());
  const auto epochs = static_cast<double>(scaling.epochs);
  const auto of_all = [&](double seconds, double lanes) { return seconds * lanes / epochs; };
  DemePlan plan;
  EpochCosts& costs = plan.costs;
  costs.core = scaling.serial_seconds.median / epochs;
  // What the cores lose by working at once is no matter of sending.
  const auto abreast = static_cast<double>(scaling.abreast);
  const double at_once = of_all(scaling.serial_seconds.median / scaling.abreast_speed_up.median, abreast);
  costs.lost = std::max(0.0, of_all(row->seconds.median, static_cast<double>(row->lanes)) - at_once);
  costs.coordinator = row->busy;
  const double lanes = static_cast<double>(hosts.hosts) * hosts.cores;
  plan.speed_up = predicted_speed_up(costs, scaling.demes, lanes);
  const double without_coordinator = predicted_speed_up({costs.core, costs.lost, 0.0}, scaling.demes, lanes);
  plan.limit = plan.speed_up < without_coordinator ? "the coordinator, which packs and unpacks every epoch on one core"
               : lanes <= scaling.demes            ? "the cores"
                                                   : "the number of demes (ga.demes)";
  plan.bytes_per_second =
      row->bytes * static_cast<double>(scaling.individuals) / epochs * plan.speed_up / std::max(costs.core, 1e-9);
  return plan;
}

}  // namespace coppice
