// Flags that take a whole number, 0 or more. CLI11 reads "-5" into an unsigned number as 2^64 - 5, and a number beyond
// 64 bits as the largest one.
#pragma once

#include <CLI/CLI.hpp>
#include <charconv>
#include <cstdint>
#include <string>
#include <system_error>

namespace coppice {

inline CLI::Validator whole_number() {
  CLI::Validator validator;
  validator.name("WHOLE").operation([](std::string& text) -> std::string {
    std::uint64_t number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    const bool whole = error == std::errc() && end == text.data() + text.size();
    return whole ? std::string() : "'" + text + "' found: expected a whole number, 0 or more";
  });
  return validator;
}

}  // namespace coppice
