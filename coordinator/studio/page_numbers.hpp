// Numbers as the page's data holds them: six significant digits are more than a screen shows, and a third of the bytes.
#pragma once

#include <cmath>
#include <concepts>
#include <cstdint>
#include <nlohmann/json.hpp>

namespace coppice {

inline nlohmann::ordered_json page_number(double value) {
  constexpr int kDigits = 6;
  if (!std::isfinite(value)) {
    return nullptr;  // JSON knows no other word for it
  }
  if (value == 0.0) {
    return 0;
  }
  const double unit = std::pow(10.0, kDigits - 1 - static_cast<int>(std::floor(std::log10(std::abs(value)))));
  const double rounded = std::round(value * unit) / unit;
  if (rounded == std::trunc(rounded) && std::abs(rounded) < 1e15) {
    return static_cast<std::int64_t>(rounded);  // 3, not 3.0
  }
  return rounded;
}

template <std::integral Number>
nlohmann::ordered_json page_number(Number value) {
  return value;
}

}  // namespace coppice
