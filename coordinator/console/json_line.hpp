// JSON as the commands print it.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace coppice {

// One line of ASCII, so that no byte of a name or a path can command a terminal; what is not UTF-8 becomes U+FFFD.
inline std::string json_line(const nlohmann::ordered_json& json) {
  return json.dump(-1, ' ', true, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace coppice
