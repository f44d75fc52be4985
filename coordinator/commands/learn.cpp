#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <memory>

#include "coordinator/commands/commands.hpp"
#include "coordinator/commands/learn_options.hpp"
#include "coordinator/commands/whole_number.hpp"

namespace coppice {
namespace {

struct Options {
  std::string study;
  LearnOptions learning;
  std::uint64_t seed = 1;
  bool json = false;
};

Result<void> learn_command(const Options& options, const StopFlag& stop) {
  const Result<LearnTask> task = learn_task(options.learning, options.seed);
  if (!task) {
    return tl::unexpected(task.error());
  }
  const Result<LearnReport> report = learn_shown(*task, options.study, stop);
  if (!report) {
    return tl::unexpected(report.error());
  }
  fmt::print("{}{}", options.json ? report->json : report->text, options.json ? "\n" : "");
  return {};
}

}  // namespace

void add_learn(CLI::App& app, Invocation& invocation) {
  const auto options = std::make_shared<Options>();
  CLI::App* command =
      app.add_subcommand("learn", "Learn a policy, count its Markov chain, and start a study with both");
  command->add_option("-o,--output", options->study, "The study file to make; must not exist")
      ->type_name("STUDY")
      ->required();
  add_learn_options(*command, options->learning);
  command->add_option("--seed", options->seed, "Same seed, same policy and chain")
      ->check(whole_number())
      ->capture_default_str();
  command->add_flag("--json", options->json, "Report as one JSON object");
  command->footer(
      "Examples:\n"
      "  coppice learn -o uav.coppice\n"
      "  coppice learn -o small.coppice --world hall.room --episodes 20000 --seed 7");
  command->callback([&invocation, options] {
    invocation.chosen = [&invocation, options] { return learn_command(*options, invocation.stop); };
  });
}

}  // namespace coppice
