#include "coordinator/bench/demes_report.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "common/duration.hpp"
#include "coordinator/console/json_line.hpp"

namespace coppice {
namespace {

using Json = nlohmann::ordered_json;

Json deme_json_of(const Spread& spread) {
  return {{"median", spread.median}, {"low", spread.low}, {"high", spread.high}};
}

std::string percent_text(const Spread& spread) {
  return fmt::format("+-{:.0f}%", 50.0 * (spread.high - spread.low) / std::max(spread.median, 1e-12));
}

}  // namespace

std::string to_text(const DemeScaling& scaling) {
  constexpr const char* kRow = "  {:<14} {:>10} {:>6} {:>10} {:>9} {:>10} {:>12}\n";
  const auto rate = [&](double seconds) {
    return fmt::format("{:.1f} k", static_cast<double>(scaling.individuals) / seconds / 1e3);
  };
  std::string text = fmt::format("\n{}: {} demes, {} epochs, {} individuals\n", scaling.name, scaling.demes,
                                 scaling.epochs, scaling.individuals);
  text += fmt::format(kRow, "", "a run", "", "ind./s", "speed-up", "bytes/ind", "busy/epoch");
  text += fmt::format(kRow, "1 thread", fmt::format("{:.3f} s", scaling.serial_seconds.median),
                      percent_text(scaling.serial_seconds), rate(scaling.serial_seconds.median), "1.00", "", "");
  text += fmt::format(kRow, fmt::format("{} runs at once", scaling.abreast), "", percent_text(scaling.abreast_speed_up),
                      rate(scaling.serial_seconds.median / scaling.abreast_speed_up.median),
                      fmt::format("{:.2f}", scaling.abreast_speed_up.median), "", "");
  for (const DemeRow& row : scaling.rows) {
    text += fmt::format(kRow, row.name, fmt::format("{:.3f} s", row.seconds.median), percent_text(row.speed_up),
                        rate(row.seconds.median), fmt::format("{:.2f}", row.speed_up.median),
                        row.bytes > 0.0 ? fmt::format("{:.0f}", row.bytes) : "",
                        row.bytes > 0.0 ? fmt::format("{:.0f} us", row.busy * 1e6) : "");
  }
  return text;
}

std::string to_text(const DemeScaling& scaling, const Hosts& hosts, const DemePlan& plan) {
  return fmt::format(
      "\n{}, {} demes, on {} hosts of {} cores: {:.1f} times the serial run, by what was measured here:\n"
      "  min( min(demes, hosts x cores) x c / (c + o), c / k ), with an epoch of c = {:.2f} ms on a core, o = {:.0f} "
      "us "
      "on its\n  way and k = {:.0f} us of the coordinator; limited by {}; {:.1f} MB a second, both ways\n",
      scaling.name, scaling.demes, hosts.hosts, hosts.cores, plan.speed_up, plan.costs.core * 1e3,
      plan.costs.lost * 1e6, plan.costs.coordinator * 1e6, plan.limit, plan.bytes_per_second / 1e6);
}

std::string paced_demes_heading(const PacingSettings& settings) {
  std::string text = fmt::format("\nworkers that take {} for an individual", in_words(settings.pace));
  if (settings.slow_workers > 0) {
    text += fmt::format(", {} of them {}", settings.slow_workers, in_words(settings.slow_pace));
  }
  return text +
         fmt::format("; epochs of {} individuals\n  {:>7} {:>5} {:>6} {:>9} {:>15} {:>7} {:>9} {:>7} {:>6} {:>11}\n",
                     kPacedIndividualsPerEpoch, "workers", "demes", "epochs", "ideal", "all epochs", "ideal/",
                     "predicted", "copies", "busy", "busy/epoch");
}

std::string to_text(const PacedDemesRow& row) {
  return fmt::format("  {:>7} {:>5} {:>6} {:>9} {:>15} {:>7} {:>9} {:>7.1f} {:>6} {:>11}\n", row.workers, row.demes,
                     row.epochs, fmt::format("{:.3f} s", row.ideal_seconds),
                     fmt::format("{:.3f} s {}", row.seconds.median, percent_text(row.seconds)),
                     fmt::format("{:.1f}%", 100.0 * row.ideal_seconds / row.seconds.median),
                     row.predicted_seconds > 0.0 ? fmt::format("{:.3f} s", row.predicted_seconds) : "", row.copies,
                     fmt::format("{:.1f}%", 100.0 * row.busy),
                     fmt::format("{:.0f} us", 1e6 * row.busy * row.seconds.median / row.epochs));
}

std::string to_json(const PacingSettings& settings, const std::vector<PacedDemesRow>& rows) {
  Json list = Json::array();
  for (const PacedDemesRow& row : rows) {
    list.push_back({{"workers", row.workers},
                    {"demes", row.demes},
                    {"epochs", row.epochs},
                    {"ideal_seconds", row.ideal_seconds},
                    {"seconds", deme_json_of(row.seconds)},
                    {"predicted_seconds", row.predicted_seconds},
                    {"copies", row.copies},
                    {"coordinator_busy", row.busy}});
  }
  return json_line({{"pace_seconds", static_cast<double>(settings.pace.count()) * 1e-9},
                    {"slow_workers", settings.slow_workers},
                    {"slow_pace_seconds", static_cast<double>(settings.slow_pace.count()) * 1e-9},
                    {"individuals_per_epoch", kPacedIndividualsPerEpoch},
                    {"repetitions", settings.repetitions},
                    {"paced_demes", list}});
}

std::string to_json(const ScalingSettings& settings, const std::vector<DemeScaling>& scaling,
                    const std::optional<Hosts>& hosts) {
  Json workloads = Json::array();
  for (const DemeScaling& workload : scaling) {
    Json rows = Json::array();
    for (const DemeRow& row : workload.rows) {
      rows.push_back({{"name", row.name},
                      {"lanes", row.lanes},
                      {"seconds", deme_json_of(row.seconds)},
                      {"speed_up", deme_json_of(row.speed_up)},
                      {"bytes_per_individual", row.bytes},
                      {"coordinator_seconds_per_epoch", row.busy}});
    }
    Json json = {{"name", workload.name},
                 {"demes", workload.demes},
                 {"epochs", workload.epochs},
                 {"individuals", workload.individuals},
                 {"serial_seconds", deme_json_of(workload.serial_seconds)},
                 {"runs_at_once", workload.abreast},
                 {"runs_at_once_speed_up", deme_json_of(workload.abreast_speed_up)},
                 {"rows", rows}};
    if (hosts) {
      const DemePlan plan = plan_of(workload, *hosts);
      json["plan"] = {{"hosts", hosts->hosts},
                      {"cores", hosts->cores},
                      {"epoch_seconds", plan.costs.core},
                      {"lost_seconds", plan.costs.lost},
                      {"coordinator_seconds", plan.costs.coordinator},
                      {"bytes_per_second", plan.bytes_per_second},
                      {"speed_up", plan.speed_up},
                      {"limit", plan.limit}};
    }
    workloads.push_back(std::move(json));
  }
  return json_line({{"cores", settings.cores}, {"repetitions", settings.repetitions}, {"demes", workloads}});
}

}  // namespace coppice
