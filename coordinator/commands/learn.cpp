#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <memory>
#include <utility>

#include "coordinator/commands/commands.hpp"
#include "coordinator/commands/learn_options.hpp"
#include "coordinator/commands/shared_flags.hpp"
#include "coordinator/runs/interrupted_learning.hpp"

namespace coppice {
namespace {

struct LearnFlags {
  std::string study;
  LearnOptions learning;
  std::uint64_t seed = 1;
  bool resume = false;
  bool json = false;
};

Result<void> learn_command(const LearnFlags& options, const StopFlag& stop) {
  InterruptedLearning start;
  if (options.resume) {
    Result<InterruptedLearning> kept = read_interrupted_learning(interrupted_learning_path(options.study));
    if (!kept) {
      return tl::unexpected(std::move(kept).error());
    }
    start = std::move(*kept);
  } else {
    Result<LearnTask> task = learn_task(options.learning, options.seed);
    if (!task) {
      return tl::unexpected(std::move(task).error());
    }
    start.task = std::move(*task);
  }
  const Result<LearnReport> report = learn_shown(start.task, options.study, stop, start.checkpoint);
  if (!report) {
    return tl::unexpected(report.error());
  }
  fmt::print("{}{}", options.json ? report->json : report->text, options.json ? "\n" : "");
  return {};
}

}  // namespace

void add_learn(CLI::App& app, Invocation& invocation) {
  const auto options = std::make_shared<LearnFlags>();
  CLI::App* command =
      app.add_subcommand("learn", "Learn a policy, count its Markov chain, and start a study with both");
  CLI::Option* output = command->add_option("-o,--output", options->study, "The study file to make; must not exist")
                            ->type_name("STUDY")
                            ->required();
  add_learn_options(*command, options->learning);
  add_seed_option(*command, options->seed, "Same seed, same policy and chain");
  CLI::Option* resume =
      command->add_flag("--resume", options->resume,
                        "Go on with learning that was interrupted, by its own settings: to the same policy and chain");
  for (CLI::Option* other : command->get_options()) {
    if (other != resume && other != output && other != command->get_help_ptr()) {
      resume->excludes(other);
    }
  }
  add_json_flag(*command, options->json);
  command->footer(
      "Examples:\n"
      "  coppice learn -o uav.coppice\n"
      "  coppice learn -o small.coppice --world hall.room --episodes 20000 --seed 7\n"
      "  coppice learn -o battery.coppice --world battery");
  command->callback([&invocation, options] {
    invocation.chosen = [&invocation, options] { return learn_command(*options, invocation.stop); };
  });
}

}  // namespace coppice
