// The folder that a command makes for its results: always a new one.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "common/error.hpp"

namespace coppice {

// Makes the folder `given`; if that is empty, one named after `stem` and the time in UTC. Errors (bad_input): it exists
// already; (failed): it cannot be made.
Result<std::filesystem::path> new_folder(const std::string& given, std::string_view stem);

}  // namespace coppice
