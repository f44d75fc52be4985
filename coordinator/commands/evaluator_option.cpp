#include "coordinator/commands/evaluator_option.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <chrono>
#include <filesystem>
#include <fmt/format.h>
#include <system_error>
#include <thread>
#include <unistd.h>
#include <utility>

#include "coordinator/commands/shared_flags.hpp"
#include "coordinator/commands/whole_number.hpp"
#include "coordinator/fleet/local_workers.hpp"

namespace coppice {
namespace {

constexpr std::size_t kMostLocalWorkers = LocalWorkers::kMaxWorkers;
constexpr double kRemoteCrossCheck = 0.01;
constexpr std::uint32_t kLongestWait = 7 * 24 * 3600;

// Found before the work that leads up to its start.
Result<std::filesystem::path> worker_program(const EvaluatorOption& option) {
  if (option.worker_program.empty()) {
    return find_worker_program();
  }
  std::error_code error;
  if (std::filesystem::is_directory(option.worker_program, error)) {
    return failed(fmt::format("--worker-program {}: is a directory", option.worker_program));
  }
  if (access(option.worker_program.c_str(), X_OK) != 0) {
    return failed(
        fmt::format("--worker-program {}: {}", option.worker_program, std::generic_category().message(errno)));
  }
  return std::filesystem::path(option.worker_program);
}

}  // namespace

void add_evaluator_option(CLI::App& command, EvaluatorOption& option) {
  CLI::Option* workers =
      command.add_option("--workers", option.workers, "Start N worker processes on this machine (default: one a core)");
  workers->type_name("N")->check(whole_number(1, kMostLocalWorkers));
  CLI::Option* serial = command.add_flag("--serial", option.serial, "Evaluate in this process");
  command
      .add_option("--threads", option.threads,
                  "With --serial: run up to N demes (ga.demes) at once; the result is the same (default: one a core)")
      ->type_name("N")
      ->check(whole_number(1, kMostThreads))
      ->needs(serial);
  CLI::Option* remote = command.add_flag("--remote", option.remote,
                                         "Use workers that were started by hand, here or on other hosts "
                                         "(coppice-worker --coordinator HOST); waits until one is there");
  workers->excludes(serial)->excludes(remote);
  serial->excludes(remote);
  command.add_option("--interface", option.interface, "With --remote: network interface or address to listen on")
      ->type_name("NAME")
      ->needs(remote);
  command
      .add_option(
          "--advertise", option.advertise,
          "With --remote: address under which workers reach this machine if it is not its own, in numbers: that of "
          "a router which forwards the UDP port")
      ->type_name("ADDRESS")
      ->needs(remote);
  command
      .add_option("--security", option.security,
                  "With --remote: folder of this coordinator's identity under DDS Security "
                  "(deploy/security/make-certificates.sh makes it); its workers need theirs")
      ->type_name("DIR")
      ->needs(remote);
  command
      .add_flag("--lossy", option.lossy,
                "With --remote: for a network that loses packets or passes only small ones; its workers should have "
                "it too")
      ->needs(remote);
  command
      .add_option("--cross-check", option.cross_check,
                  "Evaluate this share of the individuals again in this process, and quarantine a worker that answered "
                  "otherwise (default: 0.01 with --remote, else 0)")
      ->type_name("SHARE")
      ->check(CLI::Range(0.0, 1.0))
      ->excludes(serial);
  command.add_option("--domain", option.domain, "DDS domain (default: a free one; with --remote 0, as its workers)")
      ->type_name("D")
      ->check(whole_number())
      ->excludes(serial);
  command.add_option("--wait", option.wait_seconds, "Give up when there was no worker for so many seconds")
      ->type_name("SECONDS")
      ->check(whole_number())
      ->excludes(serial);
  command
      .add_option("--worker-program", option.worker_program,
                  "What --workers starts (default: coppice-worker beside this program, or on PATH)")
      ->type_name("FILE")
      ->excludes(serial)
      ->excludes(remote);
  command
      .add_option("--metrics", option.metrics.place,
                  "Serve metrics for Prometheus over HTTP at this address (127.0.0.1 if only a port is given)")
      ->type_name("[ADDRESS:]PORT");
  command
      .add_option("--metrics-file", option.metrics.file,
                  "Keep metrics in this file, for the textfile collector of Prometheus' node exporter (FILE.prom)")
      ->type_name("FILE");
}

Result<EvaluatorChoice> evaluator_choice(const EvaluatorOption& option) {
  EvaluatorChoice choice;
  if (option.serial) {
    choice.kind = EvaluatorChoice::Kind::serial;
    choice.threads =
        option.threads.value_or(std::clamp<std::size_t>(std::thread::hardware_concurrency(), 1, kMostThreads));
  } else if (option.remote) {
    choice.kind = EvaluatorChoice::Kind::remote;
  } else {
    choice.kind = EvaluatorChoice::Kind::local;
    choice.workers =
        option.workers.value_or(std::clamp<std::size_t>(std::thread::hardware_concurrency(), 1, kMostLocalWorkers));
    Result<std::filesystem::path> program = worker_program(option);
    if (!program) {
      return tl::unexpected(std::move(program).error());
    }
    choice.worker_program = std::move(*program);
  }
  if (option.interface) {
    choice.interface = *option.interface;
  }
  choice.advertise = option.advertise;
  choice.security = option.security;
  choice.lossy = option.lossy;
  choice.cross_check = option.cross_check.value_or(option.remote ? kRemoteCrossCheck : 0.0);
  if (option.domain) {
    if (*option.domain > kHighestDomain) {
      return bad_input(fmt::format("--domain is {}: expected 0 to {}", *option.domain, kHighestDomain));
    }
    choice.domain = option.domain;
  }
  if (option.wait_seconds) {
    if (*option.wait_seconds < 1 || *option.wait_seconds > kLongestWait) {
      return bad_input(fmt::format("--wait is {}: expected 1 to {} seconds", *option.wait_seconds, kLongestWait));
    }
    choice.wait_limit = std::chrono::seconds(*option.wait_seconds);
  }
  if (option.metrics.any()) {
    auto metrics = RunMetrics::open(option.metrics);
    if (!metrics) {
      return tl::unexpected(metrics.error());
    }
    choice.metrics = std::move(*metrics);
  }
  return choice;
}

}  // namespace coppice
