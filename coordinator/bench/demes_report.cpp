#include "coordinator/bench/demes_report.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

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
      "  min(demes, hosts x cores, c / k) with an epoch of c = {:.2f} ms on a core and k = {:.0f} us of the "
      "coordinator;\n"
      "  limited by {}; {:.1f} MB a second, both ways\n",
      scaling.name, scaling.demes, hosts.hosts, hosts.cores, plan.speed_up, plan.epoch_seconds * 1e3,
      plan.coordinator_seconds * 1e6, plan.limit, plan.bytes_per_second / 1e6);
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
                      {"epoch_seconds", plan.epoch_seconds},
                      {"coordinator_seconds", plan.coordinator_seconds},
                      {"bytes_per_second", plan.bytes_per_second},
                      {"speed_up", plan.speed_up},
                      {"limit", plan.limit}};
    }
    workloads.push_back(std::move(json));
  }
  return json_line({{"cores", settings.cores}, {"repetitions", settings.repetitions}, {"demes", workloads}});
}

}  // namespace coppice
