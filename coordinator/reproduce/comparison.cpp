#include "coordinator/reproduce/comparison.hpp"

#include <algorithm>
#include <fmt/format.h>

namespace coppice {
namespace {

constexpr std::size_t kGap = 2;
constexpr std::size_t kLine = 120;

const std::string& cell(const std::vector<std::string>& cells, std::size_t i) {
  static const std::string no_cell;
  return i < cells.size() ? cells[i] : no_cell;
}

// A paragraph in lines of at most kLine characters, the first after "- ".
std::string wrapped(const std::string& text) {
  std::string result = "- ";
  std::size_t column = 2;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find(' ', begin), text.size());
    const std::size_t length = end - begin;
    if (column > 2 && column + 1 + length > kLine) {
      result += "\n  ";
      column = 2;
    } else if (column > 2) {
      result += ' ';
      ++column;
    }
    result.append(text, begin, length);
    column += length;
    begin = end + 1;
  }
  return result + '\n';
}

}  // namespace

std::string to_text(const Comparison& comparison) {
  std::vector<Comparison::Row> rows = comparison.rows;
  rows.insert(rows.begin(), {"", comparison.printed_columns, comparison.our_columns});
  const std::size_t printed = comparison.printed_columns.size();
  const std::size_t ours = comparison.our_columns.size();
  std::size_t name_width = 0;
  std::vector<std::size_t> widths(printed + ours, 0);
  for (const Comparison::Row& row : rows) {
    name_width = std::max(name_width, row.name.size());
    for (std::size_t i = 0; i < widths.size(); ++i) {
      widths[i] = std::max(widths[i], (i < printed ? cell(row.printed, i) : cell(row.ours, i - printed)).size());
    }
  }
  std::size_t printed_width = 0;
  for (std::size_t i = 0; i < printed; ++i) {
    printed_width += widths[i] + kGap;
  }
  std::string text = fmt::format("{}: {}\n", comparison.name, comparison.title);
  const auto add = [&](std::string line) {
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + '\n';
  };
  add(fmt::format("{:<{}}{:<{}}| this run", "", name_width + kGap, "the thesis", printed_width));
  for (const Comparison::Row& row : rows) {
    std::string line = fmt::format("{:<{}}", row.name, name_width + kGap);
    for (std::size_t i = 0; i < printed; ++i) {
      line += fmt::format("{:<{}}", cell(row.printed, i), widths[i] + kGap);
    }
    line += "| ";
    for (std::size_t i = 0; i < ours; ++i) {
      line += fmt::format("{:<{}}", cell(row.ours, i), widths[printed + i] + kGap);
    }
    add(line);
  }
  for (const std::string& remark : comparison.remarks) {
    text += wrapped(remark);
  }
  return text;
}

nlohmann::ordered_json to_json(const Comparison& comparison) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const Comparison::Row& row : comparison.rows) {
    rows.push_back({{"name", row.name}, {"thesis", row.printed}, {"this_run", row.ours}});
  }
  return {{"table", comparison.name},
          {"title", comparison.title},
          {"thesis_columns", comparison.printed_columns},
          {"this_run_columns", comparison.our_columns},
          {"rows", rows},
          {"remarks", comparison.remarks}};
}

}  // namespace coppice
