#include "coordinator/bench/scaling.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <thread>

#include "coordinator/bench/echo.hpp"
#include "coordinator/console/counted.hpp"
#include "coordinator/dispatch/serial_evaluator.hpp"
#include "coordinator/fleet/fleet_evaluator.hpp"

namespace coppice {
namespace {

// One team: the evaluator that uses it, and as many workers that only echo.
struct Contender {
  Team team;
  std::unique_ptr<FleetEvaluator> evaluator;
  std::unique_ptr<Echo> echo;
};

// Of one contender and workload, one value a repetition.
struct Samples {
  std::vector<double> seconds;
  std::vector<double> speed_up;
  std::vector<double> overhead;
  std::vector<double> bare_seconds;
  std::vector<double> busy;
  DispatchStatistics traffic;
};

Result<std::vector<Contender>> open_contenders(const std::shared_ptr<const Chain>& chain,
                                               const ScalingSettings& settings, const StopFlag& stop) {
  std::vector<Contender> contenders;
  for (const Team& team : settings.teams) {
    FleetOptions options;
    options.local_workers = team.workers;
    options.worker_program = settings.worker_program;
    LocalWorkers::Flags flags;
    if (!settings.security.empty()) {
      options.network.security = settings.security / "coordinator";
      flags = {"--security", (settings.security / "worker").string()};
    }
    const std::vector<LocalWorkers::Flags> of_echoes(team.workers, flags);
    options.worker_threads = team.threads;
    options.worker_flags = of_echoes;
    const wire::Network network = options.network;
    auto evaluator = FleetEvaluator::open(chain, std::move(options), stop);
    if (!evaluator) {
      return tl::unexpected(evaluator.error());
    }
    if (auto ok = (*evaluator)->await_workers(team.workers); !ok) {
      return tl::unexpected(ok.error());
    }
    auto echo = Echo::open(settings.worker_program, team.workers, stop, network, of_echoes);
    if (!echo) {
      return tl::unexpected(echo.error());
    }
    contenders.push_back({team, std::move(*evaluator), std::move(*echo)});
  }
  return contenders;
}

DispatchStatistics difference(const DispatchStatistics& after, const DispatchStatistics& before) {
  DispatchStatistics result;
  result.individuals = after.individuals - before.individuals;
  result.batches = after.batches - before.batches;
  result.sent_bytes = after.sent_bytes - before.sent_bytes;
  result.received_bytes = after.received_bytes - before.received_bytes;
  return result;
}

using Generations = std::vector<std::vector<Tally>>;

Result<Generations> evaluate(Evaluator& evaluator, const Workload& workload, std::uint32_t first) {
  Generations generations;
  for (std::uint32_t i = 0; i < workload.generations; ++i) {
    auto tallies = evaluator.evaluate(workload.trees, workload.job_of(first + i));
    if (!tallies) {
      return tl::unexpected(tallies.error());
    }
    generations.push_back(std::move(*tallies));
  }
  return generations;
}

using SerialPaths = std::vector<std::unique_ptr<Evaluator>>;

// As many as the largest team can use cores.
Result<SerialPaths> serial_paths(const std::shared_ptr<const Chain>& chain, const ScalingSettings& settings,
                                 const StopFlag& stop) {
  std::size_t most = 1;
  for (const Team& team : settings.teams) {
    most = std::max(most, std::min<std::size_t>(team.lanes(), settings.cores));
  }
  SerialPaths paths;
  while (paths.size() < most) {
    auto path = SerialEvaluator::make(chain, stop);
    if (!path) {
      return tl::unexpected(path.error());
    }
    paths.push_back(std::move(*path));
  }
  return paths;
}

class WorkloadMeasurement {
 public:
  WorkloadMeasurement(const Workload& workload, const ScalingSettings& settings, const SerialPaths& serial,
                      std::vector<Contender>& contenders)
      : workload_(workload),
        settings_(settings),
        serial_(serial),
        contenders_(contenders),
        samples_(contenders.size()) {}

  Result<WorkloadScaling> run() {
    for (std::uint32_t repetition = 0; repetition <= settings_.repetitions; ++repetition) {
      // The first repetition teaches the evaluators the workload's cost and is not counted.
      if (auto ok = repeat(repetition * workload_.generations, repetition > 0); !ok) {
        return tl::unexpected(ok.error());
      }
    }
    return result();
  }

 private:
  double per_generation(double seconds) const { return seconds / workload_.generations; }

  Result<void> repeat(std::uint32_t first, bool counts) {
    const Stopwatch watch;
    const auto expected = evaluate(*serial_.front(), workload_, first);
    const double serial = per_generation(watch.seconds());
    if (!expected) {
      return tl::unexpected(expected.error());
    }
    const double abreast =
        serial_.size() == 1 ? serial : per_generation(evaluate_abreast(first)) / static_cast<double>(serial_.size());
    if (counts) {
      serial_seconds_.push_back(serial);
      abreast_seconds_.push_back(abreast);
      abreast_speed_up_.push_back(serial / abreast);
    }
    for (std::size_t i = 0; i < contenders_.size(); ++i) {
      Samples sample;
      if (auto ok = measure(contenders_[i], first, *expected, serial, sample); !ok) {
        return ok;
      }
      if (counts) {
        append(samples_[i], sample);
      }
    }
    return {};
  }

  double evaluate_abreast(std::uint32_t first) const {
    const Stopwatch watch;
    std::vector<std::thread> threads;
    threads.reserve(serial_.size());
    for (const auto& path : serial_) {
      threads.emplace_back([&] { static_cast<void>(evaluate(*path, workload_, first)); });
    }
    for (std::thread& thread : threads) {
      thread.join();
    }
    return watch.seconds();
  }

  Result<void> measure(Contender& contender, std::uint32_t first, const Generations& expected, double serial,
                       Samples& sample) const {
    const DispatchStatistics before = contender.evaluator->statistics();
    const Stopwatch watch;
    const auto got = evaluate(*contender.evaluator, workload_, first);
    const double seconds = watch.seconds();
    const double processor_seconds = watch.processor_seconds();
    if (!got) {
      return tl::unexpected(got.error());
    }
    if (*got != expected) {
      return failed(fmt::format("workload {}: {} gave other tallies than the serial path", workload_.name,
                                contender.team.name()));
    }
    sample.traffic = difference(contender.evaluator->statistics(), before);
    const double generation = per_generation(seconds);
    const auto gaining = static_cast<double>(std::min<std::size_t>(contender.team.lanes(), settings_.cores));
    sample.seconds = {generation};
    sample.speed_up = {serial / generation};
    sample.overhead = {generation - serial / gaining};
    sample.busy = {processor_seconds / seconds};
    return exchange(contender, sample);
  }

  // The same batches over the bare transport.
  Result<void> exchange(Contender& contender, Samples& sample) const {
    const std::uint64_t batches = std::max<std::uint64_t>(sample.traffic.batches, 1);
    const Echo::Traffic traffic{.batches = std::max<std::uint64_t>(batches / workload_.generations, 1),
                                .task_bytes = sample.traffic.sent_bytes / batches,
                                .answer_bytes = sample.traffic.received_bytes / batches};
    const Stopwatch watch;
    for (std::uint32_t i = 0; i < workload_.generations; ++i) {
      if (auto ok = contender.echo->exchange(traffic); !ok) {
        return ok;
      }
    }
    sample.bare_seconds = {per_generation(watch.seconds())};
    return {};
  }

  static void append(Samples& all, const Samples& sample) {
    const auto extend = [](std::vector<double>& to, const std::vector<double>& from) {
      to.insert(to.end(), from.begin(), from.end());
    };
    extend(all.seconds, sample.seconds);
    extend(all.speed_up, sample.speed_up);
    extend(all.overhead, sample.overhead);
    extend(all.bare_seconds, sample.bare_seconds);
    extend(all.busy, sample.busy);
    all.traffic.individuals += sample.traffic.individuals;
    all.traffic.batches += sample.traffic.batches;
    all.traffic.sent_bytes += sample.traffic.sent_bytes;
    all.traffic.received_bytes += sample.traffic.received_bytes;
  }

  WorkloadScaling result() const {
    WorkloadScaling scaling{workload_.name,
                            workload_.trees.size(),
                            workload_.job.rollouts,
                            workload_.job.steps,
                            spread_of(serial_seconds_),
                            serial_.size(),
                            spread_of(abreast_seconds_),
                            spread_of(abreast_speed_up_),
                            {}};
    const double generations = static_cast<double>(workload_.generations) * settings_.repetitions;
    for (std::size_t i = 0; i < contenders_.size(); ++i) {
      const Samples& samples = samples_[i];
      const auto bytes = static_cast<double>(samples.traffic.sent_bytes + samples.traffic.received_bytes);
      ScalingRow row;
      row.team = contenders_[i].team;
      row.seconds = spread_of(samples.seconds);
      row.speed_up = spread_of(samples.speed_up);
      row.overhead = spread_of(samples.overhead);
      row.bare_seconds = spread_of(samples.bare_seconds);
      row.efficiency = row.speed_up.median / static_cast<double>(row.team.lanes());
      row.batches = static_cast<double>(samples.traffic.batches) / generations;
      row.bytes = bytes / static_cast<double>(samples.traffic.individuals);
      row.busy = spread_of(samples.busy).median;
      scaling.rows.push_back(row);
    }
    return scaling;
  }

  const Workload& workload_;
  const ScalingSettings& settings_;
  const SerialPaths& serial_;
  std::vector<Contender>& contenders_;
  std::vector<double> serial_seconds_;
  std::vector<double> abreast_seconds_;
  std::vector<double> abreast_speed_up_;
  std::vector<Samples> samples_;
};

}  // namespace

std::string Team::name() const {
  return counted(workers, "worker") + (threads == 1 ? "" : fmt::format(" x {}", threads));
}

Result<std::vector<WorkloadScaling>> measure_scaling(const std::shared_ptr<const Chain>& chain,
                                                     const std::vector<Workload>& workloads,
                                                     const ScalingSettings& settings, const StopFlag& stop,
                                                     const std::function<void(const WorkloadScaling&)>& done) {
  const auto serial = serial_paths(chain, settings, stop);
  if (!serial) {
    return tl::unexpected(serial.error());
  }
  auto contenders = open_contenders(chain, settings, stop);
  if (!contenders) {
    return tl::unexpected(contenders.error());
  }
  std::vector<WorkloadScaling> all;
  for (const Workload& workload : workloads) {
    auto scaling = WorkloadMeasurement(workload, settings, *serial, *contenders).run();
    if (!scaling) {
      return tl::unexpected(scaling.error());
    }
    done(*scaling);
    all.push_back(std::move(*scaling));
  }
  return all;
}

double worthwhile_seconds(const std::vector<WorkloadScaling>& scaling, const Team& team, unsigned cores) {
  const auto gaining = static_cast<double>(std::min<std::size_t>(team.lanes(), cores));
  for (const WorkloadScaling& workload : scaling) {
    const auto row = std::find_if(workload.rows.begin(), workload.rows.end(),
                                  [&](const ScalingRow& candidate) { return candidate.team == team; });
    if (workload.steps > 1 && row != workload.rows.end() && gaining > 1.0) {
      return std::max(row->overhead.median, 0.0) / (1.0 - 1.0 / gaining);
    }
  }
  return 0.0;
}

}  // namespace coppice
