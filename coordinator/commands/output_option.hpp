// -o FILE and --force: where a command writes, and that it overwrites nothing unasked.
#pragma once

#include <string>

#include "common/error.hpp"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace coppice {

struct OutputOption {
  std::string path;  // empty: not given
  bool force = false;
};

// --force is for every file that the command writes.
CLI::Option* add_output_option(CLI::App& command, OutputOption& option, const char* help, const char* type = "FILE");

// To be asked before the work that leads up to the file. Errors (bad_input), by `flag`: the file is the study itself,
// whatever --force says; it exists and `force` is not set. A device or a pipe is written to, not overwritten; no path
// is no file.
Result<void> check_output(const char* flag, const std::string& path, bool force, const std::string& study);

}  // namespace coppice
