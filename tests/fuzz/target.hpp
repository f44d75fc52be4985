// What every fuzz target defines, for libFuzzer and for our own driver alike, and how it says what became of an input.
// A broken property is a COPPICE_CHECK: it aborts, and whoever runs the target shows the input.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "common/error.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace coppice::fuzz {

// Whether the code under test accepted the last input. A run in which it never does has tested only the first lines of
// a parser, so the driver counts. One thread.
inline bool accepted = false;

inline std::string_view as_text(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

// Without the newline that an editor puts at the end of a file, for input that is one line.
inline std::string_view one_line(std::string_view text) {
  return !text.empty() && text.back() == '\n' ? text.substr(0, text.size() - 1) : text;
}

// A message for a user: of the right kind, and not empty.
inline bool is_refusal(const Error& error) { return error.kind == ErrorKind::bad_input && !error.message.empty(); }

// The same, for parsers that promise to escape what they quote.
inline bool is_printable_refusal(const Error& error) {
  for (const char c : error.message) {
    if (c < ' ' || c > '~') {
      return false;
    }
  }
  return is_refusal(error);
}

}  // namespace coppice::fuzz
