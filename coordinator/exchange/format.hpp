// Which format a file has, told from its content.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/error.hpp"

namespace coppice {

enum class SourceFormat : std::uint8_t {
  drn = 0,      // Storm's explicit format
  prism = 1,    // PRISM explicit: .tra, with .sta, .lab, .srew and .trew beside it
  tables = 2,   // Gymnasium P tables as JSON
  csv_log = 3,  // transitions, a line each
  json_log = 4  // the same as JSON lines
};

std::string_view name_of(SourceFormat format);
// "drn", "prism", "tables", "csv", "jsonl". Error lists them.
Result<SourceFormat> format_named(std::string_view name);

// Errors: the file cannot be read; none of the formats, saying what each begins with.
Result<SourceFormat> format_of(const std::string& path);

}  // namespace coppice
