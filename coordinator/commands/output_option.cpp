#include "coordinator/commands/output_option.hpp"

#include <CLI/CLI.hpp>
#include <filesystem>
#include <fmt/format.h>
#include <system_error>

#include "coordinator/console/whole_file.hpp"

namespace coppice {

CLI::Option* add_output_option(CLI::App& command, OutputOption& option, const char* help, const char* type) {
  command.add_flag("--force", option.force, "Overwrite files that exist");
  return command.add_option("-o,--output", option.path, help)->type_name(type);
}

Result<void> check_output(const char* flag, const std::string& path, bool force, const std::string& study) {
  if (path.empty()) {
    return {};
  }
  if (const Result<void> other = check_other_file(flag, path, study); !other) {
    return other;
  }
  std::error_code error;  // what cannot be looked at does not exist, or cannot be written either
  if (!force && std::filesystem::is_regular_file(path, error)) {
    return bad_input(fmt::format("{} {} exists: expected another name, or --force to overwrite it", flag, path));
  }
  return {};
}

}  // namespace coppice
