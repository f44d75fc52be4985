#include "coordinator/commands/shared_flags.hpp"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <fmt/format.h>

#include "coordinator/commands/whole_number.hpp"

namespace coppice {

CLI::Option* add_json_flag(CLI::App& command, bool& json, const char* help) {
  return command.add_flag("--json", json, help);
}

CLI::Option* add_study_argument(CLI::App& command, std::string& study, const char* help) {
  return command.add_option("STUDY", study, help)->required();
}

CLI::Option* add_run_option(CLI::App& command, std::optional<std::int64_t>& run, const char* help) {
  return command.add_option("--run", run, help)->type_name("N")->check(whole_number());
}

CLI::Option* add_seed_option(CLI::App& command, std::uint64_t& seed, const char* help) {
  return command.add_option("--seed", seed, help)->check(whole_number())->capture_default_str();
}

CLI::Option* add_seed_option(CLI::App& command, std::optional<std::uint64_t>& seed, const char* help) {
  return command.add_option("--seed", seed, help)->check(whole_number());
}

void print_now(const std::string& text) {
  fmt::print("{}", text);
  static_cast<void>(std::fflush(stdout));
}

}  // namespace coppice
