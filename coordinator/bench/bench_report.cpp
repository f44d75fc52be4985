#include "coordinator/bench/bench_report.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "common/duration.hpp"
#include "coordinator/console/counted.hpp"
#include "coordinator/console/json_line.hpp"

namespace coppice {
namespace {

using Json = nlohmann::ordered_json;

std::string time_text(double seconds) {
  return in_words(std::chrono::nanoseconds(static_cast<std::int64_t>(std::llround(seconds * 1e9))));
}

// "1.02 ms +-3%": half the distance between the quartiles.
std::string time_text(const Spread& seconds) {
  return fmt::format("{} +-{:.0f}%", time_text(seconds.median),
                     50.0 * (seconds.high - seconds.low) / std::max(seconds.median, 1e-12));
}

std::string rate_text(double per_second) {
  return per_second >= 1e6 ? fmt::format("{:.2f} M", per_second / 1e6) : fmt::format("{:.1f} k", per_second / 1e3);
}

Json json_of(const Spread& spread) { return {{"median", spread.median}, {"low", spread.low}, {"high", spread.high}}; }

Json json_of(const Machine& machine) {
  return {
      {"processor", machine.processor}, {"cores", machine.cores}, {"system", machine.system}, {"load", machine.load}};
}

}  // namespace

std::string to_text(const Machine& machine) {
  return fmt::format("{}, {} core{}; {}; load {:.1f} before the start\n", machine.processor, machine.cores,
                     machine.cores == 1 ? "" : "s", machine.system, machine.load);
}

std::string to_text(const WorkloadScaling& scaling) {
  constexpr const char* kRow = "  {:<12} {:>15} {:>8} {:>8} {:>6} {:>14} {:>14} {:>8} {:>9} {:>6}\n";
  const auto individuals = static_cast<double>(scaling.individuals);
  std::string text = fmt::format("\n{}: {} individuals, {} x {} steps each\n", scaling.name, scaling.individuals,
                                 scaling.rollouts, scaling.steps);
  text += fmt::format(kRow, "", "generation", "ind./s", "speed-up", "eff.", "overhead", "bare DDS", "batches",
                      "bytes/ind", "busy");
  text += fmt::format(kRow, "serial", time_text(scaling.serial_seconds),
                      rate_text(individuals / scaling.serial_seconds.median), "1.00", "", "", "", "", "", "");
  if (scaling.abreast > 1) {
    text += fmt::format(
        kRow, fmt::format("{} serial", scaling.abreast), time_text(scaling.abreast_seconds),
        rate_text(individuals / scaling.abreast_seconds.median), fmt::format("{:.2f}", scaling.abreast_speed_up.median),
        fmt::format("{:.0f}%", 100.0 * scaling.abreast_speed_up.median / static_cast<double>(scaling.abreast)), "", "",
        "", "", "");
  }
  for (const ScalingRow& row : scaling.rows) {
    text += fmt::format(kRow, row.team.name(), time_text(row.seconds), rate_text(individuals / row.seconds.median),
                        fmt::format("{:.2f}", row.speed_up.median), fmt::format("{:.0f}%", 100.0 * row.efficiency),
                        time_text(row.overhead.median), time_text(row.bare_seconds), fmt::format("{:.1f}", row.batches),
                        fmt::format("{:.0f}", row.bytes), fmt::format("{:.1f}%", 100.0 * row.busy));
  }
  return text;
}

std::string verdict(const std::vector<WorkloadScaling>& scaling, unsigned cores) {
  std::string text = "\n";
  for (const ScalingRow& any : scaling.empty() ? std::vector<ScalingRow>{} : scaling.front().rows) {
    const std::string who = any.team.name();
    const auto row_of = [&](const WorkloadScaling& workload) {
      return std::find_if(workload.rows.begin(), workload.rows.end(),
                          [&](const ScalingRow& row) { return row.team == any.team; });
    };
    const auto first = std::find_if(scaling.begin(), scaling.end(), [&](const WorkloadScaling& workload) {
      return row_of(workload)->speed_up.median > 1.0;
    });
    if (any.team.lanes() == 1 || cores == 1) {
      text += fmt::format("{} cannot pay here, only cost: the serial path has the core to itself.\n", who);
      continue;
    }
    const std::string who_pays = who + (any.team.workers == 1 ? " pays" : " pay");
    if (first == scaling.end()) {
      text += fmt::format("{} in none of these workloads.", who_pays);
    } else {
      text += fmt::format("{} from the workload '{}' on (a generation of {} serially: {:.2f} times as fast).", who_pays,
                          first->name, time_text(first->serial_seconds.median), row_of(*first)->speed_up.median);
    }
    const double worthwhile = worthwhile_seconds(scaling, any.team, cores);
    text += worthwhile > 0.0 ? fmt::format(" By their overhead they break even at a generation of {} serially.\n",
                                           time_text(worthwhile))
                             : "\n";
  }
  return text +
         fmt::format(
             "generation: median and half the distance of the quartiles. N serial: serial paths at once, each with "
             "generations of\nits own: what the cores give where nothing is dispatched. overhead: beyond serial / "
             "min(threads, {} cores). bare DDS: the\nsame batches, answered at once without evaluation. bytes/ind: "
             "payload, both ways. busy: the coordinator's process, of\none core. Every tally was equal to the serial "
             "one.\n",
             cores);
}

std::string to_text(const Transfer& transfer) {
  constexpr double kMega = 1e6;
  const auto rate = [&](const Spread& seconds) {
    return fmt::format("{:.0f} MB/s", static_cast<double>(transfer.bytes) / kMega / seconds.median);
  };
  std::string text = fmt::format("\n{:.1f} MB in {}\n", static_cast<double>(transfer.bytes) / kMega,
                                 counted(transfer.blocks, "block"));
  text += fmt::format("  bare DDS, the same blocks   {:>14}  {:>9}\n", time_text(transfer.bare_seconds),
                      rate(transfer.bare_seconds));
  text += fmt::format("  to a worker                 {:>14}  {:>9}  {:.2f} of the bare rate\n",
                      time_text(transfer.seconds), rate(transfer.seconds), transfer.share.median);
  text += fmt::format("  the worker's start besides  {:>14}\n", time_text(transfer.start_seconds));
  return text +
         "to a worker: sent, hashed, decoded and made ready, less what a chain of one state takes. bare DDS: as many "
         "blocks at\nonce, each answered with a few bytes.\n";
}

std::string to_json(const Machine& machine, const TransferSettings& settings, const Transfer& transfer) {
  return json_line({{"machine", json_of(machine)},
                    {"repetitions", settings.repetitions},
                    {"bytes", transfer.bytes},
                    {"blocks", transfer.blocks},
                    {"start_seconds", json_of(transfer.start_seconds)},
                    {"transfer_seconds", json_of(transfer.seconds)},
                    {"bare_seconds", json_of(transfer.bare_seconds)},
                    {"share_of_bare_rate", json_of(transfer.share)}});
}

std::string pacing_heading(const PacingSettings& settings) {
  std::string text = fmt::format("\nworkers that take {} for an individual", in_words(settings.pace));
  if (settings.slow_workers > 0) {
    text += fmt::format(", {} of them {}", settings.slow_workers, in_words(settings.slow_pace));
  }
  return text + fmt::format("\n  {:>7} {:>11} {:>10} {:>10} {:>16} {:>10} {:>8} {:>7} {:>6} {:>9} {:>9}\n", "workers",
                            "individuals", "ideal", "first", "generation", "efficiency", "batches", "copies", "busy",
                            "all here", "all gone");
}

std::string to_text(const PacingRow& row) {
  return fmt::format("  {:>7} {:>11} {:>10} {:>10} {:>16} {:>10} {:>8.0f} {:>7.1f} {:>6} {:>9} {:>9}\n", row.workers,
                     row.individuals, time_text(row.ideal_seconds), time_text(row.first_seconds),
                     time_text(row.seconds), fmt::format("{:.1f}%", 100.0 * row.efficiency), row.batches, row.copies,
                     fmt::format("{:.0f}%", 100.0 * row.busy), time_text(row.here_seconds),
                     time_text(row.gone_seconds));
}

std::string to_json(const Machine& machine, const ScalingSettings& settings,
                    const std::vector<WorkloadScaling>& scaling) {
  Json workloads = Json::array();
  for (const WorkloadScaling& workload : scaling) {
    Json rows = Json::array();
    for (const ScalingRow& row : workload.rows) {
      rows.push_back({{"workers", row.team.workers},
                      {"threads", row.team.threads},
                      {"generation_seconds", json_of(row.seconds)},
                      {"evaluations_per_second", static_cast<double>(workload.individuals) / row.seconds.median},
                      {"speed_up", json_of(row.speed_up)},
                      {"efficiency", row.efficiency},
                      {"overhead_seconds", json_of(row.overhead)},
                      {"bare_seconds", json_of(row.bare_seconds)},
                      {"batches", row.batches},
                      {"bytes_per_individual", row.bytes},
                      {"coordinator_busy", row.busy}});
    }
    workloads.push_back(
        {{"name", workload.name},
         {"individuals", workload.individuals},
         {"rollouts", workload.rollouts},
         {"steps", workload.steps},
         {"serial",
          {{"generation_seconds", json_of(workload.serial_seconds)},
           {"evaluations_per_second", static_cast<double>(workload.individuals) / workload.serial_seconds.median}}},
         {"serial_abreast",
          {{"paths", workload.abreast},
           {"generation_seconds", json_of(workload.abreast_seconds)},
           {"speed_up", json_of(workload.abreast_speed_up)}}},
         {"workers", rows}});
  }
  Json pays = Json::array();
  for (const Team& team : settings.teams) {
    const double seconds = worthwhile_seconds(scaling, team, settings.cores);
    pays.push_back({{"workers", team.workers},
                    {"threads", team.threads},
                    {"break_even_seconds", seconds > 0.0 ? Json(seconds) : Json(nullptr)}});
  }
  return json_line({{"machine", json_of(machine)},
                    {"repetitions", settings.repetitions},
                    {"workloads", workloads},
                    {"break_even", pays}});
}

std::string to_json(const Machine& machine, const PacingSettings& settings, const std::vector<PacingRow>& rows) {
  Json paced = Json::array();
  for (const PacingRow& row : rows) {
    paced.push_back({{"workers", row.workers},
                     {"individuals", row.individuals},
                     {"ideal_seconds", row.ideal_seconds},
                     {"first_seconds", row.first_seconds},
                     {"generation_seconds", json_of(row.seconds)},
                     {"efficiency", row.efficiency},
                     {"batches", row.batches},
                     {"copies", row.copies},
                     {"coordinator_busy", row.busy},
                     {"here_seconds", row.here_seconds},
                     {"gone_seconds", row.gone_seconds}});
  }
  return json_line({{"machine", json_of(machine)},
                    {"repetitions", settings.repetitions},
                    {"pace_ns", settings.pace.count()},
                    {"slow_workers", settings.slow_workers},
                    {"slow_pace_ns", settings.slow_pace.count()},
                    {"paced", paced}});
}

}  // namespace coppice
