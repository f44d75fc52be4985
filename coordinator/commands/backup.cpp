#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <memory>
#include <string>

#include "coordinator/commands/commands.hpp"
#include "coordinator/commands/output_option.hpp"
#include "coordinator/commands/shared_flags.hpp"
#include "coordinator/study/study_backup.hpp"

namespace coppice {
namespace {

struct BackupFlags {
  std::string study;
  OutputOption output;
};

Result<void> backup_command(const BackupFlags& flags) {
  const auto& [path, force] = flags.output;
  if (const Result<void> checked = check_output("-o", path, force, flags.study); !checked) {
    return checked;
  }
  return back_up_study(flags.study, path);
}

}  // namespace

void add_backup(CLI::App& app, Invocation& invocation) {
  const auto flags = std::make_shared<BackupFlags>();
  CLI::App* command = app.add_subcommand("backup", "Copy a study, also while a run goes on in it");
  add_study_argument(*command, flags->study, "The study file; it is only read");
  add_output_option(*command, flags->output, "The copy", "STUDY")->required();
  command->footer(
      "The copy is what the study held at one moment: every generation saved by then. A run that was under way can be\n"
      "resumed from it where the first cannot go on: coppice evolve COPY --resume --take-over\n"
      "Example:\n"
      "  coppice backup uav.coppice -o uav-tuesday.coppice");
  command->callback([&invocation, flags] { invocation.chosen = [flags] { return backup_command(*flags); }; });
}

}  // namespace coppice
