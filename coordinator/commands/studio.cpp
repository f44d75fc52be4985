#include <CLI/CLI.hpp>
#include <condition_variable>
#include <cstdio>
#include <fmt/format.h>
#include <memory>
#include <mutex>
#include <utility>

#include "coordinator/commands/commands.hpp"
#include "coordinator/commands/evaluator_option.hpp"
#include "coordinator/commands/page_options.hpp"
#include "coordinator/commands/studio_breeding.hpp"
#include "coordinator/report/score.hpp"
#include "coordinator/studio/studio_server.hpp"

namespace coppice {
namespace {

struct StudioFlags {
  PageOptions page;
  EvaluatorOption evaluator;
  std::uint16_t port = 0;
};

void wait_for(const StopFlag& stop) {
  std::mutex mutex;
  std::condition_variable raised;
  bool over = false;
  const StopFlag::Wake wake = stop.on_raise([&] {
    const std::lock_guard lock(mutex);
    over = true;
    raised.notify_all();
  });
  std::unique_lock lock(mutex);
  raised.wait(lock, [&] { return over; });
}

Result<void> studio_command(const StudioFlags& options, const StopFlag& stop) {
  const Result<StudyTree> given = open_study_tree(options.page.tree);
  if (!given) {
    return tl::unexpected(given.error());
  }
  PageRequest request = page_request(options.page, given->study, given->tree, "");
  if (const Result<void> checked = check_score_settings(request.simulate); !checked) {
    return checked;
  }
  EvaluatorOption evaluator = options.evaluator;
  evaluator.serial = !evaluator.workers && !evaluator.remote;  // workers come only to those who ask for them
  Result<EvaluatorChoice> choice = evaluator_choice(evaluator);
  if (!choice) {
    return tl::unexpected(std::move(choice).error());
  }
  Result<Study> study = Study::open(options.page.tree.study, Study::Access::write);
  if (!study) {
    return tl::unexpected(std::move(study).error());
  }
  const std::string path = study->path();
  Result<std::unique_ptr<StudioSession>> session =
      StudioSession::open(std::move(*study), std::move(request), breeding_in(path, std::move(*choice)));
  if (!session) {
    return tl::unexpected(std::move(session).error());
  }
  StudioGate gate{.token = new_token()};
  // The port is known only once the server listens; until then there is nobody who could ask.
  std::mutex gate_mutex;
  std::unique_lock not_yet(gate_mutex);
  const Result<HttpServer> server = HttpServer::start(options.port, [&](const HttpRequest& asked) {
    { const std::lock_guard lock(gate_mutex); }
    return answer_of(gate, **session, asked);
  });
  if (!server) {
    return tl::unexpected(server.error());
  }
  gate.port = server->port();
  not_yet.unlock();
  fmt::print("{}\n", address_of(gate));
  if (std::fflush(stdout) != 0) {
    return failed("cannot write standard output");
  }
  fmt::print(stderr, "Open this address in a browser on this machine; it is only for you. Ctrl-C ends the studio.\n");
  wait_for(stop);
  return {};
}

}  // namespace

void add_studio(CLI::App& app, Invocation& invocation) {
  const auto options = std::make_shared<StudioFlags>();
  CLI::App* command =
      app.add_subcommand("studio", "Shape a tree by hand in a browser, with its scores, rules and the world beside");
  add_page_options(*command, options->page);
  add_evaluator_option(*command, options->evaluator);
  command->add_option("--port", options->port, "Port on 127.0.0.1 (default: any that is free)")->type_name("N");
  command->footer(
      "Prints its address, which holds a token, as its first line; only this machine can reach it.\n"
      "Trees are kept in the study when you say so. From another machine: ssh -L 8123:127.0.0.1:8123, with --port "
      "8123.\n"
      "Examples:\n"
      "  coppice studio uav.coppice\n"
      "  coppice studio uav.coppice --tree better.tree --port 8123");
  command->callback([&invocation, options] {
    invocation.chosen = [&invocation, options] { return studio_command(*options, invocation.stop); };
  });
}

}  // namespace coppice
