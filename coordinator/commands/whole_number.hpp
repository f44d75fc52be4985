// Flags that take a whole number, 0 or more. CLI11 reads "-5" into an unsigned number as 2^64 - 5, and a number beyond
// 64 bits as the largest one.
#pragma once

#include <CLI/CLI.hpp>
#include <charconv>
#include <cstdint>
#include <limits>
#include <string>
#include <system_error>

namespace coppice {

inline CLI::Validator whole_number(std::uint64_t lowest = 0,
                                   std::uint64_t highest = std::numeric_limits<std::uint64_t>::max()) {
  CLI::Validator validator;
  validator.name("WHOLE").operation([lowest, highest](std::string& text) -> std::string {
    std::uint64_t number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    const bool whole = error == std::errc() && end == text.data() + text.size();
    if (whole && number >= lowest && number <= highest) {
      return {};
    }
    const bool bounded = highest != std::numeric_limits<std::uint64_t>::max();
    return "'" + text + "' found: expected a whole number, " + std::to_string(lowest) +
           (bounded ? " to " + std::to_string(highest) : std::string(" or more"));
  });
  return validator;
}

}  // namespace coppice
