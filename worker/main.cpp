// coppice-worker: command line, signals and log; serve.hpp does the work.
#include <CLI/CLI.hpp>
#include <csignal>
#include <exception>
#include <memory>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <string>
#include <sys/prctl.h>
#include <unistd.h>
#include <vector>

#include "common/cores.hpp"
#include "common/duration.hpp"
#include "common/exit_code.hpp"
#include "common/json_log.hpp"
#include "common/metrics/outlet.hpp"
#include "common/stop.hpp"
#include "common/version.hpp"
#include "common/wire/credentials.hpp"
#include "common/wire/topics.hpp"
#include "worker/apart.hpp"
#include "worker/echo.hpp"
#include "worker/figures.hpp"
#include "worker/serve.hpp"

namespace {

constexpr std::uint32_t kMaxThreads = 1024;
constexpr std::uint32_t kMaxPort = 65535;
constexpr int kWrongUse = coppice::to_int(coppice::ExitCode::wrong_use);

// A worker that a coordinator started dies with it, also when that was killed.
bool follow_parent(pid_t parent) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  return getppid() == parent;  // else it died before prctl
}

// Before any thread is started. Each lane keeps to one of them then (worker/lane.hpp); what DDS starts may use them
// all, and wakes where the lanes that it serves are, not beside those of another worker.
coppice::Result<void> settle_on(const std::vector<int>& cores, std::uint32_t threads) {
  if (cores.empty()) {
    return {};
  }
  if (cores.size() != threads) {
    return coppice::bad_input(
        fmt::format("found {}, expected as many as there are evaluating threads, {}", cores.size(), threads));
  }
  return coppice::stay_on_cores(cores);
}

int complain(const coppice::Error& error) {
  spdlog::error("{}", error.message);
  return coppice::to_int(coppice::exit_code_of(error));
}

int run(int argc, char** argv) {
  CLI::App app{"Evaluates behaviour trees for a Coppice coordinator until it gets SIGTERM.", "coppice-worker"};
  coppice::ServeOptions options;
  options.version = coppice::kVersion;
  options.protocol = coppice::wire::kProtocolVersion;
  pid_t parent = 0;
  std::string log_level = "info";
  std::string log_format = "text";
  std::string pace;
  std::string security;
  coppice::MetricsTargets metrics;
  std::string health;
  bool echoes = false;
  bool apart = false;
  app.set_version_flag(
      "--version", fmt::format("coppice-worker {} (protocol {})", coppice::kVersion, coppice::wire::kProtocolVersion));
  app.add_option("--coordinator", options.coordinator, "Host of the coordinator")->capture_default_str();
  app.add_option("--domain", options.domain, "DDS domain; the coordinator listens on UDP port 7410 + 250 x domain")
      ->check(CLI::Range(0U, coppice::wire::kMaxDomain))
      ->capture_default_str();
  app.add_option("--port", options.network.port,
                 "UDP port to listen on, if a firewall must let one through (default: one that the system chooses)")
      ->type_name("PORT")
      ->check(CLI::Range(1U, kMaxPort));
  app.add_option("--security", security,
                 "Folder of this worker's identity under DDS Security (deploy/security/make-certificates.sh makes it)")
      ->type_name("DIR");
  app.add_flag("--lossy", options.network.lossy,
               "For a network that loses packets or passes only small ones; its coordinator should have it too");
  app.add_option("--threads", options.threads, "Evaluating threads")
      ->check(CLI::Range(1U, kMaxThreads))
      ->capture_default_str();
  app.add_option("--cores", options.cores,
                 "Keep each evaluating thread on a core of its own, for a machine that does little else: as many "
                 "numbers as there are threads, as 0,1,2,3. A coordinator does so with workers of its own that fill "
                 "the machine")
      ->type_name("CORE,...")
      ->delimiter(',');
  app.add_option("--pace", pace,
                 "Take at least so long for each individual: evaluate it, then rest. For capacity planning, many "
                 "workers on few cores; results are the same")
      ->type_name("DURATION");
  app.add_option("--cache", options.cache,
                 "Folder to keep chains in, so that a worker that is started again need not be sent them again")
      ->type_name("DIR");
  app.add_option(
         "--metrics", metrics.place,
         "Serve metrics for Prometheus over HTTP at this address (127.0.0.1 if only a port is given), with /health "
         "and /ready for those who supervise")
      ->type_name("[ADDRESS:]PORT");
  app.add_option("--metrics-file", metrics.file,
                 "Keep metrics in this file, for the textfile collector of Prometheus' node exporter (FILE.prom)")
      ->type_name("FILE");
  app.add_option("--health", health,
                 "Ask the worker whose --metrics this is how it does, print it, and exit: 0 alive, else 1. For health "
                 "checks of containers")
      ->type_name("[ADDRESS:]PORT");
  app.add_flag("--echo", echoes, "Answer every task at once, for the bare transport in 'coppice bench'")->group("");
  app.add_flag("--apart", apart, "Evaluate one task from standard input, for the coordinator that started it")
      ->group("");
  app.add_option("--log-level", log_level, "What to log to stderr")
      ->check(CLI::IsMember({"debug", "info", "warn", "error", "off"}))
      ->capture_default_str();
  app.add_option("--log-format", log_format, "Lines of text, or a JSON object a line")
      ->check(CLI::IsMember({"text", "json"}))
      ->capture_default_str();
  app.add_option("--parent", parent, "Exit when this process, which must be the parent, dies");
  app.footer(
      "Examples:\n"
      "  coppice-worker --coordinator 192.0.2.7 --domain 3 --threads 8\n"
      "  coppice-worker --pace 2ms\n"
      "Exit codes:\n" +
      coppice::exit_codes_text());
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kWrongUse;
  }
  if (log_format == "json") {
    spdlog::set_default_logger(
        std::make_shared<spdlog::logger>("coppice-worker", coppice::json_log_sink(stderr, "coppice-worker")));
  } else {
    spdlog::set_default_logger(spdlog::stderr_color_mt("coppice-worker"));
    spdlog::set_pattern("%n: %v");
  }
  spdlog::set_level(spdlog::level::from_str(log_level));
  if (const auto fits = settle_on(options.cores, options.threads); !fits) {
    spdlog::error("--cores: {}", fits.error().message);
    return kWrongUse;
  }
  if (!pace.empty()) {
    const auto duration = coppice::duration_of(pace);
    if (!duration) {
      spdlog::error("--pace: {}", duration.error().message);
      return kWrongUse;
    }
    options.pace = *duration;
  }
  if (!security.empty()) {
    if (const auto checked = coppice::wire::check_credentials(security); !checked) {
      return complain(checked.error());
    }
    if (const std::string warning = coppice::wire::expiry_warning(security); !warning.empty()) {
      spdlog::warn("{}", warning);
    }
    options.network.security = security;
  }
  if (parent != 0 && !follow_parent(parent)) {
    return 0;
  }
  if (apart) {
    const auto done = coppice::evaluate_apart();
    return done ? 0 : complain(done.error());
  }
  if (!health.empty()) {
    const auto healthy = coppice::ask_health("--health", health, "/health");
    fmt::print("{}\n", healthy ? *healthy : healthy.error().message);
    return healthy ? 0 : coppice::to_int(coppice::exit_code_of(healthy.error()));
  }
  options.figures->manager = coppice::ServiceManager::from_environment();
  coppice::block_stop_signals();
  std::unique_ptr<coppice::MetricsOutlet> outlet;
  if (metrics.any()) {
    auto opened = coppice::MetricsOutlet::open(
        metrics,
        {.text =
             [&] { return coppice::to_metrics(*options.figures, options.version, options.network.security.string()); },
         .health = [&] { return options.figures->health(); }});
    if (!opened) {
      return complain(opened.error());
    }
    outlet = std::move(*opened);
    if (!metrics.place.empty()) {
      spdlog::info("metrics at port {} (--metrics {})", outlet->port(), metrics.place);
    }
  }
  coppice::StopFlag stop;
  const coppice::StopOnSignals signals(stop);
  coppice::wire::route_dds_log([](const char* line) { spdlog::debug("dds: {}", coppice::wire::shown(line)); });
  const auto outcome = echoes ? coppice::echo(options, stop) : coppice::serve(options, stop);
  return outcome ? 0 : complain(outcome.error());
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    static_cast<void>(std::fprintf(stderr, "coppice-worker: %s\n", error.what()));
    return coppice::to_int(coppice::ExitCode::environment);
  }
}
