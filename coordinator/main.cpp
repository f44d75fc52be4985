// The program `coppice`: composes the parts, reads the command line, and turns the outcome into an exit code
// (common/exit_code.hpp).
#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstdio>
#include <exception>
#include <fcntl.h>
#include <fmt/format.h>
#include <iostream>
#include <string>
#include <system_error>
#include <unistd.h>

#include "common/exit_code.hpp"
#include "common/stop.hpp"
#include "common/version.hpp"
#include "coordinator/commands/command_groups.hpp"
#include "coordinator/commands/commands.hpp"
#include "coordinator/commands/did_you_mean.hpp"
#include "coordinator/console/best_effort.hpp"
#include "coordinator/console/log.hpp"
#include "coordinator/console/printable.hpp"

namespace {

using coppice::ExitCode;
using coppice::Result;

int complain(const std::string& message, ExitCode exit_code) {
  coppice::show(stderr, fmt::format("coppice: {}\n", coppice::printable(message)));
  return coppice::to_int(exit_code);
}

// A closed standard descriptor would go to the next file that is opened, and then be read or printed to as if it were
// the user's. So it becomes /dev/null: standard input ends at once, standard error is lost; standard output is opened
// for reading, because results that cannot be printed are a failure.
void fill_closed_descriptors() {
  for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (fcntl(descriptor, F_GETFD) < 0 && errno == EBADF) {
      open("/dev/null", descriptor == STDERR_FILENO ? O_WRONLY : O_RDONLY);  // takes the lowest free descriptor
    }
  }
}

// A flag or argument that was given without a value, as --tree "$EMPTY" does, must not pass for one that was not given.
Result<void> check_nothing_empty(const CLI::App& app) {
  for (const CLI::App* command : app.get_subcommands()) {
    for (const CLI::Option* option : command->get_options()) {
      for (const std::string& value : option->results()) {
        if (value.empty()) {
          return coppice::bad_input(
              fmt::format("{} is empty: expected {}", option->get_name(), option->get_type_name()));
        }
      }
    }
  }
  return {};
}

// "coppice", or "coppice evolve" once the command line got that far.
std::string spoken_to(const CLI::App& app) {
  const auto chosen = app.get_subcommands();
  return chosen.empty() ? "coppice" : "coppice " + chosen.front()->get_name();
}

// What was printed must have arrived: a full disk behind `> table.csv` is a failure.
Result<void> flush_output() {
  std::cout.flush();
  if (!std::cout || std::fflush(stdout) != 0 || std::ferror(stdout) != 0) {
    return coppice::failed(fmt::format("cannot write standard output: {}", std::generic_category().message(errno)));
  }
  return {};
}

int run(int argc, char** argv) {
  coppice::block_stop_signals();
  coppice::StopFlag stop;
  const coppice::StopOnSignals on_signals(stop);
  coppice::Invocation invocation{stop, {}};

  CLI::App app("Grows small behaviour trees that do what a learned policy does.", "coppice");
  app.set_version_flag("--version", fmt::format("coppice {}", coppice::kVersion));
  app.require_subcommand(1);
  std::string log_level = "warn";
  app.add_option("--log-level", log_level, "What to log to standard error; goes before the command")
      ->check(CLI::IsMember({"debug", "info", "warn", "error", "off"}))
      ->capture_default_str();
  std::string log_format = "text";
  app.add_option("--log-format", log_format, "Lines of text, or a JSON object a line; goes before the command")
      ->check(CLI::IsMember({"text", "json"}))
      ->capture_default_str();
  app.footer(
      "'coppice help COMMAND' explains a command, 'coppice help' lists topics, 'coppice help exit-codes' how commands "
      "end.\n"
      "To begin: coppice run");
  coppice::add_run(app, invocation);
  coppice::add_learn(app, invocation);
  coppice::add_import(app, invocation);
  coppice::add_evolve(app, invocation);
  coppice::add_refine(app, invocation);
  coppice::add_score(app, invocation);
  coppice::add_verify(app, invocation);
  coppice::add_explain(app, invocation);
  coppice::add_edit(app, invocation);
  coppice::add_prune(app, invocation);
  coppice::add_draw(app, invocation);
  coppice::add_export(app, invocation);
  coppice::add_front(app, invocation);
  coppice::add_report(app, invocation);
  coppice::add_studio(app, invocation);
  coppice::add_table(app, invocation);
  coppice::add_evaluate(app, invocation);
  coppice::add_synth(app, invocation);
  coppice::add_info(app, invocation);
  coppice::add_reproduce(app, invocation);
  coppice::add_workers(app, invocation);
  coppice::add_sweep(app, invocation);
  coppice::add_bench(app, invocation);
  coppice::add_check(app, invocation);
  coppice::add_backup(app, invocation);
  coppice::add_help(app, invocation);
  coppice::add_completion(app, invocation);
  coppice::group_commands(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& shown) {  // --help, --version
    app.exit(shown);
    const Result<void> flushed = flush_output();
    return flushed ? 0 : complain(flushed.error().message, ExitCode::environment);
  } catch (const CLI::ParseError& error) {
    if (app.get_subcommands().empty() && !app.remaining().empty()) {
      const std::string word = app.remaining().front();
      return complain(fmt::format("'{}' is no command{} (see coppice --help)", word, coppice::did_you_mean(word, app)),
                      ExitCode::wrong_use);
    }
    if (const auto chosen = app.get_subcommands(); !chosen.empty() && !chosen.front()->remaining().empty()) {
      const std::string word = chosen.front()->remaining().front();
      return complain(fmt::format("{}: '{}' was not expected{} (see {} --help)", chosen.front()->get_name(), word,
                                  coppice::did_you_mean(word, *chosen.front()), spoken_to(app)),
                      ExitCode::wrong_use);
    }
    return complain(fmt::format("{} (see {} --help)", error.what(), spoken_to(app)), ExitCode::wrong_use);
  }
  if (const Result<void> checked = check_nothing_empty(app); !checked) {
    return complain(fmt::format("{} (see {} --help)", checked.error().message, spoken_to(app)), ExitCode::wrong_use);
  }
  coppice::log_to(stderr, spdlog::level::from_str(log_level),
                  log_format == "json" ? coppice::LogFormat::json : coppice::LogFormat::text);
  Result<void> done = invocation.chosen();
  if (done) {
    done = flush_output();
  }
  if (!done) {
    static_cast<void>(std::fflush(stdout));  // the command has failed already
    return complain(done.error().message, coppice::exit_code_of(done.error()));
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  fill_closed_descriptors();
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    return complain(error.what(), ExitCode::environment);
  }
}
