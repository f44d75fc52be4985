// The simulation of dispatch by hand: seeds at will, or one run as a finding's command line says.
//   simulate --seeds A:B [--mutation NAME]         every seed from A to B - 1; stops at the first finding and
//                                                  makes it smaller
//   simulate --seed S [--workers N] [--guests N] [--clients N] [--demes N] [--requests N] [--units N]
//            [--faults none|I,J,...] [--mutation NAME]
//   simulate --arrive N                            so many workers that come at once, and what each costs in memory
//   simulate --mutations                           their names
#include <CLI/CLI.hpp>
#include <chrono>
#include <csignal>
#include <fmt/format.h>
#include <unistd.h>

#include "coordinator/dispatch/mutation.hpp"
#include "tests/simulation/trial.hpp"

namespace {

using namespace coppice;
using namespace coppice::simulation;

std::uint64_t running = 0;  // seed

// A broken COPPICE_CHECK: name the seed before the process ends.
void on_abort(int signal) {
  std::array<char, 64> text{};
  const auto end = fmt::format_to_n(text.data(), text.size(), "seed {} ended the process\n", running);
  static_cast<void>(!write(STDERR_FILENO, text.data(), end.size));
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

void show(const Scenario& scenario) {
  fmt::print(
      "seed {}: {} workers of {} lanes ({}){}, {} guests; {} requesters, {} of them demes, x {} requests of {} units "
      "in {} portions, {} us each; "
      "messages take {} us and more, {} of a million are lost, {} come twice; cross-check {} in 1000\n",
      scenario.seed, scenario.workers, scenario.lanes, scenario.own_processes ? "own processes" : "of other hosts",
      scenario.at_once ? " at once" : "", scenario.guests, scenario.clients, scenario.demes, scenario.requests,
      scenario.units, scenario.portions, scenario.each / kMicrosecond, scenario.delay / kMicrosecond, scenario.lost,
      scenario.doubled, scenario.cross_check);
  for (const Fault& fault : scenario.faults) {
    fmt::print("  {}\n", in_words(fault));
  }
}

int found(const Scenario& scenario, const Finding& finding, const std::string& mutation) {
  fmt::print("seed {}: {}\nmaking it smaller ...\n", scenario.seed, finding.how);
  const Scenario small = shrunk(scenario, finding);
  show(small);
  fmt::print("{}\n", command_of(small, mutation));
  return 1;
}

struct Options {
  std::string seeds;
  std::optional<std::uint64_t> seed;
  std::optional<std::uint32_t> workers, guests, clients, demes, requests, units, arrive;
  std::string faults;
  std::string mutation;
  bool names = false;
};

int run_seeds(std::uint64_t begin, std::uint64_t end, const std::string& mutation) {
  const auto start = std::chrono::steady_clock::now();
  std::uint64_t requests = 0;
  double simulated = 0.0;
  for (running = begin; running < end; ++running) {
    const Scenario scenario = scenario_of(running);
    Report report;
    if (const auto finding = run_here(scenario, &report)) {
      return found(scenario, *finding, mutation);
    }
    requests += report.requests;
    simulated += static_cast<double>(report.simulated) / kSecond;
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  fmt::print("{} runs, {} requests, {:.0f} s of simulated time in {:.1f} s: every promise held\n", end - begin,
             requests, simulated, seconds);
  return 0;
}

int run_one(const Options& options) {
  Scenario scenario = scenario_of(*options.seed);
  scenario.workers = options.workers.value_or(scenario.workers);
  scenario.guests = options.guests.value_or(scenario.guests);
  scenario.demes = options.demes.value_or(scenario.demes);
  scenario.clients = options.clients.value_or(scenario.clients);
  scenario.requests = options.requests.value_or(scenario.requests);
  scenario.units = options.units.value_or(scenario.units);
  if (!options.faults.empty()) {
    std::vector<Fault> kept;
    std::istringstream list(options.faults == "none" ? "" : options.faults);
    for (std::string index; std::getline(list, index, ',');) {
      kept.push_back(scenario.faults.at(std::stoul(index)));
    }
    scenario.faults = kept;
  }
  show(scenario);
  Report report;
  running = scenario.seed;
  if (const auto finding = run_here(scenario, &report)) {
    fmt::print("{}\n", finding->how);
    return 1;
  }
  fmt::print("{} requests in {} steps, {:.1f} s of simulated time: every promise held\n", report.requests, report.steps,
             static_cast<double>(report.simulated) / kSecond);
  return 0;
}

int arrive(std::uint32_t workers) {
  Report report;
  const auto start = std::chrono::steady_clock::now();
  if (const auto finding = run_here(arrival_of(workers), &report)) {
    fmt::print("{}\n", finding->how);
    return 1;
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  fmt::print(
      "{} workers at once: all are ready after {:.0f} ms, {} units done after {:.0f} ms of simulated time; {:.1f} s; "
      "the "
      "dispatcher keeps {} bytes for a worker\n",
      workers, static_cast<double>(report.all_ready) / kMillisecond, 10 * workers,
      static_cast<double>(report.simulated) / kMillisecond, seconds, bytes_of_a_worker(workers));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Simulates dispatch under faults, from seeds"};
  Options options;
  app.add_option("--seeds", options.seeds, "A:B: from A to B - 1");
  app.add_option("--seed", options.seed, "One run");
  app.add_option("--workers", options.workers, "Of that run");
  app.add_option("--guests", options.guests, "Of that run");
  app.add_option("--demes", options.demes, "Of that run");
  app.add_option("--arrive", options.arrive, "So many workers that come at once");
  app.add_option("--clients", options.clients, "Of that run");
  app.add_option("--requests", options.requests, "Of that run");
  app.add_option("--units", options.units, "Of that run");
  app.add_option("--faults", options.faults, "Only these of that run's faults, or none");
  app.add_option("--mutation", options.mutation, "A fault put into the dispatcher");
  app.add_flag("--mutations", options.names, "Print their names");
  CLI11_PARSE(app, argc, argv);
  if (options.names) {
    for (const char* const name : kMutationNames) {
      fmt::print("{}\n", name);
    }
    return 0;
  }
  if (!options.mutation.empty() && !set_mutation(options.mutation)) {
    fmt::print(stderr, "simulate: --mutation {}: not known; see --mutations\n", options.mutation);
    return 2;
  }
  std::signal(SIGABRT, on_abort);
  if (options.arrive) {
    return arrive(*options.arrive);
  }
  if (options.seed) {
    return run_one(options);
  }
  std::uint64_t begin = 0;
  std::uint64_t end = 0;
  if (std::sscanf(options.seeds.c_str(), "%lu:%lu", &begin, &end) != 2 || end <= begin) {
    fmt::print(stderr, "simulate: expected --seeds A:B with A < B, or --seed S\n");
    return 2;
  }
  return run_seeds(begin, end, options.mutation);
}
