#include "common/duration.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <fmt/format.h>

namespace coppice {
namespace {

struct Unit {
  std::string_view name;
  double nanoseconds;
};

constexpr std::array<Unit, 4> kUnits = {{{"s", 1e9}, {"ms", 1e6}, {"us", 1e3}, {"ns", 1.0}}};
constexpr double kLongestSeconds = 3600.0;

}  // namespace

Result<std::chrono::nanoseconds> duration_of(std::string_view text) {
  double number = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  const std::string_view unit = text.substr(static_cast<std::size_t>(end - text.data()));
  for (const Unit& known : kUnits) {
    const double nanoseconds = std::round(number * known.nanoseconds);
    if (error == std::errc() && unit == known.name && nanoseconds >= 1.0 && nanoseconds <= kLongestSeconds * 1e9) {
      return std::chrono::nanoseconds(static_cast<std::int64_t>(nanoseconds));
    }
  }
  return bad_input(fmt::format(
      "'{}' is no span of time: expected a number and its unit (ns, us, ms, s), as in 2ms; at most 3600s", text));
}

std::string in_words(std::chrono::nanoseconds duration) {
  const auto nanoseconds = static_cast<double>(duration.count());
  for (const Unit& unit : kUnits) {
    if (std::abs(nanoseconds) >= unit.nanoseconds) {
      return fmt::format("{:.3g} {}", nanoseconds / unit.nanoseconds, unit.name);
    }
  }
  return "0 s";
}

}  // namespace coppice
