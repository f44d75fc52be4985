// Spans of time as a user writes them: a number and its unit, "500us", "2ms", "1.5s".
#pragma once

#include <chrono>
#include <string>
#include <string_view>

#include "common/error.hpp"

namespace coppice {

// Positive and at most an hour; fractions are rounded to nanoseconds. Errors: what was found and what was expected.
Result<std::chrono::nanoseconds> duration_of(std::string_view text);

// The shortest such text with three significant digits: "2 ms", "1.53 s".
std::string in_words(std::chrono::nanoseconds duration);

}  // namespace coppice
