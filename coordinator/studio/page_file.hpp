// The page itself, built from page/ and embedded in the program: one HTML file. With data inside it is a report, which
// asks the network for nothing; without, it is the studio, which asks the server that it came from.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace coppice {

// The studio's page. Its content security policy lets it connect to where it came from and nowhere else.
std::string studio_page();

// A whole HTML file with the data inside; its content security policy lets it connect nowhere.
std::string report_page(const nlohmann::ordered_json& data);

}  // namespace coppice
