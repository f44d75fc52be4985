#include "coordinator/exchange/format.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>

#include "coordinator/exchange/line_reader.hpp"
#include "coordinator/exchange/text_number.hpp"

namespace coppice {
namespace {

constexpr std::size_t kLooked = 65536;  // bytes

std::string_view first_line_of(std::string_view text) { return trimmed(text.substr(0, text.find('\n'))); }

// The first line that is neither blank nor a comment.
std::string_view first_content(std::string_view text) {
  while (!text.empty()) {  // ends: every turn takes a line away
    const std::string_view line = first_line_of(text);
    if (!line.empty() && line.substr(0, 2) != "//" && line.front() != '#') {
      return line;
    }
    const std::size_t end = text.find('\n');
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  }
  return {};
}

bool all_whole(std::string_view line, std::size_t least, std::size_t most) {
  std::size_t words = 0;
  for (std::string_view word = take_word(line); !word.empty(); word = take_word(line)) {
    if (!to_whole(word)) {
      return false;
    }
    ++words;
  }
  return words >= least && words <= most;
}

// A JSON value that is complete within its line: one of several, or the whole file's only one.
bool ends_within(std::string_view line) {
  int depth = 0;
  bool in_text = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (in_text) {
      i += c == '\\' ? 1 : 0;
      in_text = c != '"';
    } else if (c == '"') {
      in_text = true;
    } else if (c == '{' || c == '[') {
      ++depth;
    } else if (c == '}' || c == ']') {
      --depth;
    }
  }
  return depth == 0 && !in_text;
}

}  // namespace

Result<SourceFormat> format_of(const std::string& path) {
  auto bytes = first_bytes(path, kLooked);
  if (!bytes) {
    return tl::unexpected(bytes.error());
  }
  std::string_view text = *bytes;
  if (text.substr(0, 3) == "\xEF\xBB\xBF") {  // a byte order mark, as spreadsheets write it
    text.remove_prefix(3);
  }
  const std::string_view line = first_content(text);
  if (line.substr(0, 1) == "@") {
    return SourceFormat::drn;
  }
  if (line.substr(0, 1) == "{") {
    const bool log = line.find("\"coppice-log-1\"") != std::string_view::npos ||
                     (ends_within(line) && line.find("\"action\"") != std::string_view::npos &&
                      line.find("\"P\"") == std::string_view::npos);
    return log ? SourceFormat::json_log : SourceFormat::tables;
  }
  if (line.substr(0, 1) == "[") {
    return SourceFormat::tables;
  }
  if (all_whole(line, 2, 3)) {
    return SourceFormat::prism;
  }
  const bool has_action = line.find("action") != std::string_view::npos;
  if (line.find(',') != std::string_view::npos && has_action) {
    return SourceFormat::csv_log;
  }
  return bad_input(
      fmt::format("{}: line 1: no format is known that begins so: expected Storm DRN (@type: MDP), PRISM explicit (a "
                  ".tra file: states "
                  "choices transitions), P tables (JSON), or a log (CSV with a column 'action', or JSON lines)",
                  path));
}

}  // namespace coppice
