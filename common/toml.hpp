// TOML through toml++, whatever the text. Version 3.3 as a header alone answers some malformed keys ("[", "[,a]") with
// an assertion instead of an error (Debian's library, built without assertions, does not); here that is an error like
// any other, in every kind of build.
#pragma once

#include <algorithm>
#include <cstddef>
#include <fmt/format.h>
#include <stdexcept>
#include <string>
#include <string_view>

#include "common/error.hpp"

namespace coppice {

struct TomlAssertion : std::logic_error {
  using std::logic_error::logic_error;
};

[[noreturn]] inline void toml_assertion_failed(const char* expression) { throw TomlAssertion(expression); }

}  // namespace coppice

#ifdef TOML_ASSERT
#error "toml++ was included before: expected common/toml.hpp instead"
#endif
#define TOML_ASSERT(expression) ((expression) ? static_cast<void>(0) : ::coppice::toml_assertion_failed(#expression))
#pragma push_macro("NDEBUG")
#undef NDEBUG  // toml++ takes the macro away where it is defined
#include <toml++/toml.h>
#pragma pop_macro("NDEBUG")

namespace coppice {

// The first line, from 1, with which toml++ meets its assertion: everything before it was read without one.
inline std::size_t toml_assertion_line(std::string_view text) {
  std::size_t line = 0;
  for (std::size_t end = 0; end < text.size(); ++line) {  // ends: every turn takes a line
    const std::size_t newline = text.find('\n', end);
    end = newline == std::string_view::npos ? text.size() : newline + 1;
    try {
      static_cast<void>(toml::parse(text.substr(0, end)));
    } catch (const toml::parse_error&) {
      continue;  // cut short, or wrong in another way
    } catch (const TomlAssertion&) {
      return line + 1;
    }
  }
  return std::max<std::size_t>(line, 1);
}

// Errors: "NAME: line 3, column 7: what is wrong". Never throws on any text.
inline Result<toml::table> parse_toml(std::string_view text, const std::string& name) {
  try {
    return toml::parse(text, std::string_view(name));
  } catch (const toml::parse_error& error) {
    return bad_input(fmt::format("{}: line {}, column {}: {}", name, error.source().begin.line,
                                 error.source().begin.column, error.description()));
  } catch (const TomlAssertion&) {
    return bad_input(fmt::format("{}: line {}: a malformed key: expected letters, digits, - and _, or a name in quotes",
                                 name, toml_assertion_line(text)));
  }
}

}  // namespace coppice
