#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fmt/format.h>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>
#include <unistd.h>

#include "coordinator/commands/commands.hpp"
#include "coordinator/commands/shared_flags.hpp"
#include "coordinator/console/counted.hpp"
#include "coordinator/console/json_line.hpp"
#include "coordinator/console/printable.hpp"
#include "coordinator/fleet/worker_list.hpp"

namespace coppice {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::uint32_t kHighestPort = 65535;
constexpr std::chrono::milliseconds kRefresh{1000};
constexpr std::chrono::milliseconds kStopLook{20};

struct WorkersFlags {
  WorkerListOptions list;
  std::string security;
  bool watch = false;
  bool json = false;
};

Json json_of(const WorkerList& list) {
  Json json;
  json["coordinator"] = nullptr;
  if (list.coordinator) {
    json["coordinator"] = {{"host", list.coordinator->host},
                           {"pid", list.coordinator->pid},
                           {"version", list.coordinator->version},
                           {"chain", list.coordinator->chain}};
  }
  json["workers"] = Json::array();
  for (const ListedWorker& worker : list.workers) {
    json["workers"].push_back({{"host", worker.host},
                               {"pid", worker.pid},
                               {"cores", worker.cores},
                               {"threads", worker.threads},
                               {"version", worker.version},
                               {"protocol", worker.protocol},
                               {"doing", worker.doing},
                               {"evaluated", worker.evaluated},
                               {"each_second", worker.each_second},
                               {"seen_seconds", static_cast<double>(worker.seen.count()) / 1000.0}});
  }
  return json;
}

std::string text_of(const WorkerList& list, std::uint32_t domain) {
  std::string text =
      list.coordinator
          ? fmt::format("domain {}: coordinator {}, pid {}, version {}, chain {}; {}\n", domain,
                        printable(list.coordinator->host), list.coordinator->pid, printable(list.coordinator->version),
                        list.coordinator->chain, counted(list.workers.size(), "worker"))
          : fmt::format("domain {}: no coordinator; {}\n", domain, counted(list.workers.size(), "waiting worker"));
  if (list.workers.empty()) {
    return text;
  }
  std::size_t width = 4;
  for (const ListedWorker& worker : list.workers) {
    width = std::max(width, printable(worker.host).size());
  }
  text += fmt::format("  {:<{}}      pid  cores  threads  protocol   evaluated  each second  seen ago  doing\n", "host",
                      width);
  for (const ListedWorker& worker : list.workers) {
    fmt::format_to(std::back_inserter(text), "  {:<{}} {:>8}  {:>5}  {:>7}  {:>8}  {:>10}  {:>11}  {:>6.1f} s  {}\n",
                   printable(worker.host), width, worker.pid, worker.cores, worker.threads, worker.protocol,
                   worker.evaluated, worker.each_second, static_cast<double>(worker.seen.count()) / 1000.0,
                   printable(worker.doing));
  }
  return text;
}

Result<void> workers_command(const WorkersFlags& options, const StopFlag& stop) {
  const bool redraw = options.watch && !options.json && isatty(STDOUT_FILENO) != 0;
  while (!stop.raised()) {
    const auto list = list_workers(options.list, stop);
    if (!list && list.error().kind == ErrorKind::interrupted) {
      break;  // the way to end --watch
    }
    if (!list && (!options.watch || list.error().kind == ErrorKind::bad_input)) {
      return tl::unexpected(list.error());
    }
    const std::string text = !list          ? printable(list.error().message) + "\n"
                             : options.json ? json_line(json_of(*list)) + "\n"
                                            : text_of(*list, options.list.domain);
    print_now((redraw ? "\x1b[H\x1b[J" : "") + text);
    if (!options.watch) {
      return {};
    }
    const auto next = std::chrono::steady_clock::now() + kRefresh;
    while (!stop.raised() && std::chrono::steady_clock::now() < next) {
      std::this_thread::sleep_for(kStopLook);
    }
  }
  return options.watch ? Result<void>{} : Result<void>(interrupted());
}

}  // namespace

void add_workers(CLI::App& app, Invocation& invocation) {
  const auto options = std::make_shared<WorkersFlags>();
  CLI::App* command = app.add_subcommand("workers", "List the workers of a domain and what they do");
  command->add_option("--domain", options->list.domain, "DDS domain")
      ->type_name("D")
      ->check(CLI::Range(0U, kHighestDomain))
      ->capture_default_str();
  CLI::Option* coordinator = command->add_option("--coordinator", options->list.coordinator,
                                                 "Ask the coordinator on this host (default: this machine)");
  coordinator->type_name("HOST");
  command
      ->add_option("--interface", options->list.interface,
                   "Of this machine: where its coordinator listens, or where to wait for workers if it has none "
                   "(default: any of its own, or lo)")
      ->type_name("NAME")
      ->excludes(coordinator);
  command
      ->add_option("--security", options->security,
                   "Folder of a coordinator's identity under DDS Security (deploy/security/make-certificates.sh)")
      ->type_name("DIR");
  command
      ->add_option(
          "--port", options->list.port,
          "UDP port of this machine for a coordinator's answer, if a firewall must let one through (default: one "
          "that the system chooses)")
      ->type_name("PORT")
      ->check(CLI::Range(1U, kHighestPort));
  command->add_flag("--watch", options->watch, "List again every second, until Ctrl-C");
  add_json_flag(*command, options->json, "One JSON object a list");
  command->footer(
      "Where there is no coordinator it listens for 1.5 s in its place; a coordinator that starts meanwhile waits.\n"
      "Examples:\n"
      "  coppice workers --coordinator 192.0.2.7 --domain 3\n"
      "  coppice workers --interface eth0 --watch");
  command->callback([&invocation, options] {
    invocation.chosen = [&invocation, options] {
      options->list.security = options->security;
      return workers_command(*options, invocation.stop);
    };
  });
}

}  // namespace coppice
