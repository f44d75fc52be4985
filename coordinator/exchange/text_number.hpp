// Numbers in the text formats of other tools, without locale and at the speed of std::from_chars.
#pragma once

#include <charconv>
#include <cstdint>
#include <optional>
#include <string_view>

namespace coppice {

inline bool is_text_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

inline std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_text_blank(text.front())) {
    text.remove_prefix(1);
  }
  while (!text.empty() && is_text_blank(text.back())) {
    text.remove_suffix(1);
  }
  return text;
}

// Takes the next word, blanks before it passed over; empty at the end.
inline std::string_view take_word(std::string_view& text) {
  text = trimmed(text);
  std::size_t length = 0;
  while (length < text.size() && !is_text_blank(text[length])) {
    ++length;
  }
  const std::string_view word = text.substr(0, length);
  text.remove_prefix(length);
  return word;
}

// The whole text is one number ("1e-3", "+2", "-inf", "nan"); nothing otherwise.
inline std::optional<double> to_double(std::string_view text) {
  if (text.size() > 1 && text.front() == '+') {
    text.remove_prefix(1);
  }
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc::result_out_of_range && end == text.data() + text.size()) {
    // Too small or too large for a double; the latter shows as an exponent without a minus.
    return text.find("e-") != std::string_view::npos || text.find("E-") != std::string_view::npos ? std::optional(0.0)
                                                                                                  : std::nullopt;
  }
  return error == std::errc{} && end == text.data() + text.size() ? std::optional(value) : std::nullopt;
}

// The same, or a fraction of two numbers ("1/3").
inline std::optional<double> to_fraction(std::string_view text) {
  const std::size_t slash = text.find('/');
  if (slash == std::string_view::npos) {
    return to_double(text);
  }
  const auto above = to_double(text.substr(0, slash));
  const auto below = to_double(text.substr(slash + 1));
  return above && below && *below != 0.0 ? std::optional(*above / *below) : std::nullopt;
}

inline std::optional<std::uint64_t> to_whole(std::string_view text) {
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size() ? std::optional(value) : std::nullopt;
}

}  // namespace coppice
