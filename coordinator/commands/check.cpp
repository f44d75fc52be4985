#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "coordinator/commands/commands.hpp"
#include "coordinator/commands/shared_flags.hpp"
#include "coordinator/console/counted.hpp"
#include "coordinator/console/json_line.hpp"
#include "coordinator/console/printable.hpp"
#include "coordinator/study/study_check.hpp"

namespace coppice {
namespace {

using Json = nlohmann::ordered_json;

struct CheckFlags {
  std::string study;
  bool json = false;
};

Json json_of(const StudyCheck& check, const std::string& path) {
  Json runs = Json::array();
  for (const CheckedRun& run : check.runs) {
    runs.push_back({{"run", run.run},
                    {"status", run.status},
                    {"generations", run.generations},
                    {"resumable", run.resumable},
                    {"damage", run.damage}});
  }
  return {{"study", path}, {"whole", check.whole()}, {"damage", check.damage}, {"runs", runs}, {"trees", check.trees}};
}

std::string text_of(const StudyCheck& check, const std::string& path) {
  std::uint64_t generations = 0;
  for (const CheckedRun& run : check.runs) {
    generations += run.generations;
  }
  if (check.whole()) {
    return fmt::format("{}: whole: {}, {}\n", path, counted(check.runs.size(), "run"),
                       counted(generations, "generation"));
  }
  std::string text;
  for (const std::string& damage : check.damage) {
    text += fmt::format("damaged: {}\n", printable(damage));
  }
  for (const CheckedRun& run : check.runs) {
    text += fmt::format("run {}, {}, {}: {}{}\n", run.run, run.status, counted(run.generations, "generation"),
                        run.damage.empty() ? "whole" : "damaged", run.resumable ? ", can be resumed" : "");
    for (const std::string& damage : run.damage) {
      text += fmt::format("  {}\n", printable(damage));
    }
  }
  if (!check.trees.empty()) {
    text += "trees that can be saved, as --tree takes them:\n";
    for (const std::string& tree : check.trees) {
      text += printable(tree) + "\n";
    }
  }
  return text;
}

Result<void> check_command(const CheckFlags& flags) {
  const Result<StudyCheck> check = check_study(flags.study);
  if (!check) {
    return tl::unexpected(check.error());
  }
  fmt::print("{}", flags.json ? json_line(json_of(*check, flags.study)) + "\n" : text_of(*check, flags.study));
  return check->whole()
             ? Result<void>()
             : Result<void>(tl::unexpected(Error{ErrorKind::damaged, fmt::format("{} is damaged", flags.study)}));
}

}  // namespace

void add_check(CLI::App& app, Invocation& invocation) {
  const auto flags = std::make_shared<CheckFlags>();
  CLI::App* command =
      app.add_subcommand("check", "Look through all that a study holds: what is damaged, what can be saved");
  add_study_argument(*command, flags->study, "The study file; it is only read");
  add_json_flag(*command, flags->json);
  command->footer(
      "Ends with 0 if all of it can be read, with 1 if not.\n"
      "Example:\n"
      "  coppice check uav.coppice");
  command->callback([&invocation, flags] { invocation.chosen = [flags] { return check_command(*flags); }; });
}

}  // namespace coppice
