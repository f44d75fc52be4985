// Values that users give by name: the value of an enumeration is its place in the list of its names.
#pragma once

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <string_view>

#include "common/error.hpp"

namespace coppice {

// names[i] is the name of the value i. Error (bad_input): "no WHAT 'NAME': expected one of ..."
template <typename Enumeration, std::size_t kValues>
Result<Enumeration> value_named(std::string_view what, std::string_view name,
                                const std::array<std::string_view, kValues>& names) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) {
    return bad_input(fmt::format("no {} '{}': expected one of {}", what, name, fmt::join(names, ", ")));
  }
  return static_cast<Enumeration>(found - names.begin());
}

}  // namespace coppice
