// Values that users give by name. An enumeration gets its names in one place, right behind it, in the order of its
// values, which start at 0:
//   enum class Acting : std::uint8_t { tree = 0, policy = 1, mixed = 2 };
//   template <>
//   inline constexpr std::array kNames<Acting> = names("tree", "policy", "mixed");
// and then has name_of() and value_named().
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>

#include "common/error.hpp"

namespace coppice {

template <typename... Text>
constexpr std::array<std::string_view, sizeof...(Text)> names(Text... text) {
  return {std::string_view(text)...};
}

template <typename Enumeration>
inline constexpr std::array<std::string_view, 0> kNames{};

template <typename Enumeration>
concept Named = !kNames<Enumeration>.empty();

template <Named Enumeration>
constexpr std::string_view name_of(Enumeration value) {
  return kNames<Enumeration>.at(static_cast<std::size_t>(value));
}

// Error (bad_input): "no WHAT 'NAME': expected one of ..."
template <Named Enumeration>
Result<Enumeration> value_named(std::string_view what, std::string_view name) {
  const auto found = std::find(kNames<Enumeration>.begin(), kNames<Enumeration>.end(), name);
  if (found == kNames<Enumeration>.end()) {
    std::string message = "no " + std::string(what) + " '" + std::string(name) + "': expected one of ";
    for (const std::string_view& known : kNames<Enumeration>) {
      message.append(&known == kNames<Enumeration>.begin() ? "" : ", ").append(known);
    }
    return bad_input(std::move(message));
  }
  return static_cast<Enumeration>(found - kNames<Enumeration>.begin());
}

}  // namespace coppice
