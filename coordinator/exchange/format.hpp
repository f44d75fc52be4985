// Which format a file has, told from its content.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/error.hpp"
#include "common/named.hpp"

namespace coppice {

enum class SourceFormat : std::uint8_t {
  drn = 0,      // Storm's explicit format
  prism = 1,    // PRISM explicit: .tra, with .sta, .lab, .srew and .trew beside it
  tables = 2,   // Gymnasium P tables as JSON
  csv_log = 3,  // transitions, a line each
  json_log = 4  // the same as JSON lines
};

template <>
inline constexpr std::array kNames<SourceFormat> = names("drn", "prism", "tables", "csv", "jsonl");

// Errors: the file cannot be read; none of the formats, saying what each begins with.
Result<SourceFormat> format_of(const std::string& path);

}  // namespace coppice
