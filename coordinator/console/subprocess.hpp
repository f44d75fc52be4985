// Other people's programs that draw for us: Graphviz' dot, gnuplot. They are found on PATH, read what they shall draw
// from standard input, and write a file.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/error.hpp"

namespace coppice {

bool has_program(std::string_view name);

// Runs arguments[0] until it ends. Errors (failed): it cannot be started, or did not end with exit code 0; then with
// the first line of what it said. REQUIRES: arguments not empty.
Result<void> run_program(std::vector<std::string> arguments, std::string_view input);

}  // namespace coppice
