#include "coordinator/console/printable.hpp"

#include <cstddef>
#include <cstdint>
#include <fmt/format.h>
#include <iterator>

namespace coppice {
namespace {

struct Decoded {
  std::uint32_t code_point = 0;
  std::size_t length = 0;  // 0: not UTF-8
};

// The well-formed sequences of Unicode 15, table 3-7: no overlong form, no surrogate, nothing above U+10FFFF.
Decoded decode_utf8(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<std::uint32_t>(static_cast<unsigned char>(text[i])); };
  const std::uint32_t first = byte(0);
  std::size_t length = 1;
  std::uint32_t code_point = first;
  std::uint32_t smallest = 0;
  if (first >= 0xC2 && first <= 0xDF) {
    length = 2;
    code_point = first & 0x1FU;
    smallest = 0x80;
  } else if (first >= 0xE0 && first <= 0xEF) {
    length = 3;
    code_point = first & 0x0FU;
    smallest = 0x800;
  } else if (first >= 0xF0 && first <= 0xF4) {
    length = 4;
    code_point = first & 0x07U;
    smallest = 0x10000;
  } else if (first >= 0x80) {
    return {};
  }
  if (text.size() < length) {
    return {};
  }
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xC0U) != 0x80U) {
      return {};
    }
    code_point = code_point << 6U | (byte(i) & 0x3FU);
  }
  const bool surrogate = code_point >= 0xD800 && code_point <= 0xDFFF;
  if (code_point < smallest || surrogate || code_point > 0x10FFFF) {
    return {};
  }
  return {code_point, length};
}

bool obeyed_by_terminals(std::uint32_t code_point) {
  const bool control = code_point < 0x20 || (code_point >= 0x7F && code_point < 0xA0);
  const bool line_break = code_point == 0x2028 || code_point == 0x2029;
  const bool direction = code_point == 0x061C || code_point == 0x200E || code_point == 0x200F ||
                         (code_point >= 0x202A && code_point <= 0x202E) ||
                         (code_point >= 0x2066 && code_point <= 0x2069);
  return control || line_break || direction;
}

}  // namespace

std::string printable(std::string_view text) {
  std::string result;
  result.reserve(text.size());
  while (!text.empty()) {
    const Decoded decoded = decode_utf8(text);
    if (decoded.length > 0 && !obeyed_by_terminals(decoded.code_point)) {
      result.append(text.substr(0, decoded.length));
      text.remove_prefix(decoded.length);
      continue;
    }
    const std::size_t length = decoded.length > 0 ? decoded.length : 1;
    for (const char c : text.substr(0, length)) {
      fmt::format_to(std::back_inserter(result), "\\x{:02x}", static_cast<unsigned>(static_cast<unsigned char>(c)));
    }
    text.remove_prefix(length);
  }
  return result;
}

}  // namespace coppice
