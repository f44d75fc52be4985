#include "coordinator/studio/page_file.hpp"

#include "common/check.hpp"
#include "coordinator/console/json_line.hpp"
#include "coordinator/studio/built_page.hpp"

namespace coppice {
namespace {

// page/build.mjs puts each of them into the page once.
constexpr std::string_view kDataMark = "<!--coppice-data-->";
constexpr std::string_view kConnectMark = "coppice-connect";

std::string with(std::string page, std::string_view mark, const std::string& replacement) {
  const std::size_t at = page.find(mark);
  COPPICE_CHECK(at != std::string::npos);
  return page.replace(at, mark.size(), replacement);
}

// As a script element may hold it: "<" could begin the end of the element, or a comment.
std::string script_safe(const std::string& json) {
  std::string safe;
  safe.reserve(json.size());
  for (const char c : json) {
    if (c == '<') {
      safe += "\\u003c";
    } else {
      safe += c;
    }
  }
  return safe;
}

}  // namespace

std::string studio_page() { return with(with(std::string(built_page()), kConnectMark, "'self'"), kDataMark, ""); }

std::string report_page(const nlohmann::ordered_json& data) {
  return with(with(std::string(built_page()), kConnectMark, "'none'"), kDataMark,
              "<script type=\"application/json\" id=\"coppice-data\">" + script_safe(json_line(data)) + "</script>");
}

}  // namespace coppice
