#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cstdio>
#include <fmt/format.h>
#include <memory>
#include <optional>
#include <vector>

#include "common/duration.hpp"
#include "coordinator/bench/bench_report.hpp"
#include "coordinator/bench/demes_report.hpp"
#include "coordinator/bench/machine.hpp"
#include "coordinator/bench/paced_demes.hpp"
#include "coordinator/bench/pacing.hpp"
#include "coordinator/bench/scaling.hpp"
#include "coordinator/commands/commands.hpp"
#include "coordinator/commands/evaluator_option.hpp"
#include "coordinator/commands/shared_flags.hpp"
#include "coordinator/commands/whole_number.hpp"
#include "coordinator/fleet/local_workers.hpp"
#include "coordinator/learning/learn.hpp"
#include "coordinator/study/study.hpp"

namespace coppice {
namespace {

constexpr std::uint64_t kEpisodes = 50'000;  // for the chain of our own: most states of the default room, in 0.2 s
constexpr std::uint64_t kMostRepetitions = 1000;
constexpr std::uint64_t kMostPopulation = 1'000'000;

struct BenchFlags {
  std::string study;
  std::string worker_program;
  std::string security;
  std::vector<std::string> workers = {"1", "2", "4"};
  std::vector<std::string> workloads;
  std::uint32_t repetitions = 7;
  std::string pace;
  std::string slow;  // K:DURATION
  std::uint32_t population = 0;
  bool transfer = false;
  bool demes = false;
  std::vector<std::string> plan;  // hosts=N cores=N
  bool json = false;
};

Result<std::shared_ptr<const Chain>> chain_of(const BenchFlags& options, const StopFlag& stop) {
  if (!options.study.empty()) {
    const Result<Study> study = Study::open(options.study, Study::Access::read);
    if (!study) {
      return tl::unexpected(study.error());
    }
    return std::make_shared<const Chain>(study->chain());
  }
  const Result<World> world = load_world("uav");
  if (!world) {
    return tl::unexpected(world.error());
  }
  LearnSettings settings = default_settings(world->kind, Algorithm::q_learning);
  settings.episodes = kEpisodes;
  Result<Learned> learned = learn(*world, settings, [&](std::uint64_t) { return !stop.raised(); });
  if (!learned) {
    return tl::unexpected(learned.error());
  }
  return std::make_shared<const Chain>(std::move(learned->chain));
}

Result<std::vector<Workload>> workloads_of(const BenchFlags& options, const Chain& chain) {
  std::vector<Workload> all = standard_workloads(chain);
  if (options.workloads.empty()) {
    return all;
  }
  std::vector<Workload> chosen;
  for (const std::string& name : options.workloads) {
    const auto found =
        std::find_if(all.begin(), all.end(), [&](const Workload& workload) { return workload.name == name; });
    if (found == all.end()) {
      return bad_input(
          fmt::format("--workloads: no workload '{}': expected some of empty, light, medium, heavy", name));
    }
    chosen.push_back(*found);
  }
  return chosen;
}

// "2", or "1x2": one worker of two threads.
Result<Team> team_of(const std::string& text) {
  Team team;
  const char* const end = text.data() + text.size();
  auto read = std::from_chars(text.data(), end, team.workers);
  if (read.ec == std::errc() && read.ptr != end && *read.ptr == 'x') {
    read = std::from_chars(read.ptr + 1, end, team.threads);
  }
  if (read.ec != std::errc() || read.ptr != end || team.workers < 1 || team.workers > LocalWorkers::kMaxWorkers ||
      team.threads < 1 || team.threads > kMostThreads) {
    return bad_input(fmt::format("--workers: '{}' found: expected 1 to {}, or workers x threads of each, as in 1x2",
                                 text, LocalWorkers::kMaxWorkers));
  }
  return team;
}

Result<std::vector<Team>> teams_of(const BenchFlags& options) {
  std::vector<Team> teams;
  for (const std::string& text : options.workers) {
    const auto team = team_of(text);
    if (!team) {
      return tl::unexpected(team.error());
    }
    teams.push_back(*team);
  }
  return teams;
}

// "1:20ms".
Result<void> read_slow(const std::string& text, PacingSettings& settings) {
  std::size_t count = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), count);
  if (error != std::errc() || end == text.data() + text.size() || *end != ':' || count == 0) {
    return bad_input(fmt::format("--slow: '{}' found: expected how many workers and their pace, as in 1:20ms", text));
  }
  const auto pace = duration_of(std::string_view(text).substr(static_cast<std::size_t>(end + 1 - text.data())));
  if (!pace) {
    return in_context("--slow", pace.error());
  }
  const std::size_t fewest = *std::min_element(settings.workers.begin(), settings.workers.end());
  if (count > fewest) {
    return bad_input(
        fmt::format("--slow: {} workers found: expected at most {}, the fewest of --workers", count, fewest));
  }
  settings.slow_workers = count;
  settings.slow_pace = *pace;
  return {};
}

Result<PacingSettings> pacing_of(const BenchFlags& options, const std::vector<Team>& teams,
                                 const std::filesystem::path& worker_program) {
  PacingSettings settings;
  settings.workers.clear();
  for (const Team& team : teams) {
    if (team.threads > 1) {
      return bad_input(fmt::format("--workers: {} found: expected numbers of workers with --pace", team.name()));
    }
    settings.workers.push_back(team.workers);
  }
  settings.population = options.population;
  settings.repetitions = options.repetitions;
  settings.worker_program = worker_program;
  const auto pace = duration_of(options.pace);
  if (!pace) {
    return in_context("--pace", pace.error());
  }
  settings.pace = *pace;
  if (!options.slow.empty()) {
    if (auto ok = read_slow(options.slow, settings); !ok) {
      return tl::unexpected(ok.error());
    }
  }
  return settings;
}

Result<void> bench_pacing(const PacingSettings& settings, const std::shared_ptr<const Chain>& chain,
                          const Machine& machine, bool json, const StopFlag& stop) {
  if (!json) {
    print_now(pacing_heading(settings));
  }
  const auto rows = measure_pacing(chain, settings, stop, [&](const PacingRow& row) {
    if (!json) {
      print_now(to_text(row));
    }
  });
  if (!rows) {
    return tl::unexpected(rows.error());
  }
  print_now(json ? to_json(machine, settings, *rows) + "\n"
                 : "ideal: every worker busy to the end. first: no pace is known yet. all here: from the first start "
                   "until all hold\nthe chain. all gone: until the last process has ended. Every tally was equal to "
                   "the serial one.\n");
  return {};
}

Result<void> bench_scaling(const ScalingSettings& settings, const std::vector<Workload>& workloads,
                           const std::shared_ptr<const Chain>& chain, const Machine& machine, bool json,
                           const StopFlag& stop) {
  const auto scaling = measure_scaling(chain, workloads, settings, stop, [&](const WorkloadScaling& workload) {
    if (!json) {
      print_now(to_text(workload));
    }
  });
  if (!scaling) {
    return tl::unexpected(scaling.error());
  }
  print_now(json ? to_json(machine, settings, *scaling) + "\n" : verdict(*scaling, settings.cores));
  return {};
}

Result<void> bench_paced_demes(const PacingSettings& settings, const std::shared_ptr<const Chain>& chain, bool json,
                               const StopFlag& stop) {
  if (!json) {
    print_now(paced_demes_heading(settings));
  }
  const auto rows = measure_paced_demes(chain, settings, stop, [&](const PacedDemesRow& row) {
    if (!json) {
      print_now(to_text(row));
    }
  });
  if (!rows) {
    return tl::unexpected(rows.error());
  }
  print_now(
      json ? to_json(settings, *rows) + "\n"
           : "ideal: every worker busy to the end. predicted: by the formula of --plan, from the first row. busy: of "
             "a core, the\ncoordinator. copies: epochs sent a second time, a run. Every run ended as the serial "
             "one.\n");
  return {};
}

// "hosts=64" "cores=16".
Result<Hosts> hosts_of(const std::vector<std::string>& words) {
  Hosts hosts;
  for (const std::string& word : words) {
    const std::size_t equals = word.find('=');
    const std::string name = word.substr(0, equals);
    std::uint32_t* const field = name == "hosts" ? &hosts.hosts : name == "cores" ? &hosts.cores : nullptr;
    const char* const begin = word.data() + std::min(word.size(), equals + 1);
    const char* const end = word.data() + word.size();
    if (equals == std::string::npos || field == nullptr || std::from_chars(begin, end, *field).ptr != end ||
        *field < 1 || *field > kMostThreads * kMostThreads) {
      return bad_input(fmt::format("--plan: '{}' found: expected hosts=N and cores=N, as in hosts=64 cores=16", word));
    }
  }
  return hosts;
}

Result<void> bench_demes(const ScalingSettings& settings, const std::shared_ptr<const Chain>& chain,
                         const std::optional<Hosts>& hosts, bool json, const StopFlag& stop) {
  const auto scaling = measure_demes(chain, deme_workloads(), settings, stop, [&](const DemeScaling& workload) {
    if (!json) {
      print_now(to_text(workload));
    }
  });
  if (!scaling) {
    return tl::unexpected(scaling.error());
  }
  if (json) {
    print_now(to_json(settings, *scaling, hosts) + "\n");
    return {};
  }
  if (hosts) {
    for (const DemeScaling& workload : *scaling) {
      print_now(to_text(workload, *hosts, plan_of(workload, *hosts)));
    }
  }
  print_now(
      "a run: with its last comparison, median and half the distance of the quartiles. runs at once: serial runs, each "
      "its own: what\nthe cores give. bytes/ind: payload, both ways, of an individual evaluated. busy/epoch: processor "
      "time of the coordinator.\nEvery run ended as the serial one.\n");
  return {};
}

Result<void> bench_command(const BenchFlags& options, const StopFlag& stop) {
  EvaluatorOption local;
  local.worker_program = options.worker_program;
  const auto program = evaluator_choice(local);
  if (!program) {
    return tl::unexpected(program.error());
  }
  const auto teams = teams_of(options);
  if (!teams) {
    return tl::unexpected(teams.error());
  }
  std::optional<PacingSettings> pacing;
  if (!options.pace.empty()) {
    auto settings = pacing_of(options, *teams, program->worker_program);
    if (!settings) {
      return tl::unexpected(settings.error());
    }
    pacing = std::move(*settings);
  }
  std::optional<Hosts> hosts;
  if (!options.plan.empty()) {
    const auto read = hosts_of(options.plan);
    if (!read) {
      return tl::unexpected(read.error());
    }
    hosts = *read;
  }
  const auto chain = chain_of(options, stop);
  if (!chain) {
    return tl::unexpected(chain.error());
  }
  const auto workloads = workloads_of(options, **chain);
  if (!workloads) {
    return tl::unexpected(workloads.error());
  }
  const Machine machine = this_machine();
  if (!options.json) {
    print_now(to_text(machine));
    print_now(fmt::format("chain: {} states, {} actions, {} transitions; {} repetitions side by side\n",
                          (*chain)->states(), (*chain)->actions(), (*chain)->transitions(), options.repetitions));
  }
  if (pacing && options.demes) {
    return bench_paced_demes(*pacing, *chain, options.json, stop);
  }
  if (pacing) {
    return bench_pacing(*pacing, *chain, machine, options.json, stop);
  }
  if (options.transfer) {
    const TransferSettings settings{options.repetitions, program->worker_program};
    const auto transfer = measure_transfer(*chain, settings, stop);
    if (!transfer) {
      return tl::unexpected(transfer.error());
    }
    print_now(options.json ? to_json(machine, settings, *transfer) + "\n" : to_text(*transfer));
    return {};
  }
  const ScalingSettings settings{.teams = *teams,
                                 .repetitions = options.repetitions,
                                 .worker_program = program->worker_program,
                                 .security = options.security,
                                 .cores = machine.cores};
  if (options.demes || hosts) {
    return bench_demes(settings, *chain, hosts, options.json, stop);
  }
  return bench_scaling(settings, *workloads, *chain, machine, options.json, stop);
}

}  // namespace

void add_bench(CLI::App& app, Invocation& invocation) {
  const auto options = std::make_shared<BenchFlags>();
  CLI::App* command =
      app.add_subcommand("bench", "Measure evaluation: the serial path, then workers, side by side on this machine");
  command->add_option("--study", options->study,
                      "The study whose chain to evaluate on (default: one that is learned now)");
  command
      ->add_option("--workers", options->workers,
                   "Numbers of worker processes to try, or processes x threads of each (default: 1,2,4)")
      ->type_name("N|NxT,...")
      ->delimiter(',');
  command->add_option("--repetitions", options->repetitions, "How often everything is measured; medians are printed")
      ->check(whole_number(1, kMostRepetitions))
      ->capture_default_str();
  CLI::Option* workloads =
      command->add_option("--workloads", options->workloads, "Which of empty, light, medium and heavy (default: all)")
          ->type_name("NAME,...")
          ->delimiter(',');
  CLI::Option* pace = command
                          ->add_option("--pace", options->pace,
                                       "Capacity planning instead: workers that take so long for an individual, "
                                       "many more than cores, against the ideal")
                          ->type_name("DURATION")
                          ->excludes(workloads);
  command->add_option("--slow", options->slow, "With --pace: K of the workers take DURATION")
      ->type_name("K:DURATION")
      ->needs(pace);
  command
      ->add_option("--population", options->population,
                   "With --pace: individuals (default: 50 for each worker; with --demes 10, which are one deme)")
      ->check(whole_number(1, kMostPopulation))
      ->needs(pace);
  command->add_flag("--transfer", options->transfer, "How fast the chain reaches a worker instead, beside bare DDS")
      ->excludes(pace)
      ->excludes(workloads);
  command
      ->add_flag("--demes", options->demes,
                 "Whole evolutions in demes instead: on threads and on workers; with --pace, on such workers")
      ->excludes(workloads);
  command
      ->add_option("--plan", options->plan,
                   "With --demes, which it implies: how they would do on such hosts, and what limits them")
      ->type_name("hosts=N cores=N")
      ->expected(2)
      ->excludes(pace)
      ->excludes(workloads);
  command
      ->add_option("--worker-program", options->worker_program,
                   "What to start (default: coppice-worker beside this program, or on PATH)")
      ->type_name("FILE");
  command
      ->add_option("--security", options->security,
                   "Under DDS Security, with the identities that deploy/security/make-certificates.sh put there")
      ->type_name("DIR")
      ->excludes(pace);
  add_json_flag(*command, options->json);
  command->footer(
      "Fails if any worker gives another result than the serial path.\n"
      "Examples:\n"
      "  coppice bench --workers 1,2,1x2\n"
      "  coppice bench --transfer --study large.coppice\n"
      "  coppice bench --pace 2ms --workers 1,8,64\n"
      "  coppice bench --workers 1,2 --plan hosts=64 cores=16\n"
      "  coppice bench --demes --pace 1ms --workers 1,8,64\n"
      "  coppice bench --pace 2ms --workers 20 --slow 1:20ms");
  command->callback([&invocation, options] {
    invocation.chosen = [&invocation, options] { return bench_command(*options, invocation.stop); };
  });
}

}  // namespace coppice
