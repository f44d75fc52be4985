// Files that appear whole or not at all: written under another name in the same folder, then renamed. A symbolic link
// stays and the file that it leads to is written; a file that exists keeps its mode; what is not a regular file (a
// device, a pipe) is written directly.
#pragma once

#include <filesystem>
#include <functional>
#include <ostream>
#include <string_view>

#include "common/error.hpp"

namespace coppice {

// `fill` writes the content; a file of that name is replaced. Errors name the path and the system's reason; then
// nothing was changed.
Result<void> write_whole_file(const std::filesystem::path& path, const std::function<void(std::ostream&)>& fill);
Result<void> write_whole_file(const std::filesystem::path& path, std::string_view content);

// Lets another program write the file: `produce` gets the temporary path and returns what went wrong, if anything.
Result<void> produce_whole_file(const std::filesystem::path& path,
                                const std::function<Result<void>(const std::filesystem::path&)>& produce);

// Error (bad_input): `output` is the file `input`, by whatever name. `flag` is what `output` was given with.
Result<void> check_other_file(const char* flag, const std::filesystem::path& output,
                              const std::filesystem::path& input);

}  // namespace coppice
