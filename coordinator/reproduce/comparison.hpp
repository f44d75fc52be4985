// A table of the thesis beside ours: the printed cells as they are printed, ours from real runs, and below them what
// differs and why. A plain value.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace coppice {

struct Comparison {
  struct Row {
    std::string name;
    std::vector<std::string> printed;  // as the thesis has them; empty where it prints none
    std::vector<std::string> ours;
  };

  std::string name;   // "Table 5-2"
  std::string title;  // what it is about, and where the thesis has it
  std::vector<std::string> printed_columns;
  std::vector<std::string> our_columns;
  std::vector<Row> rows;
  std::vector<std::string> remarks;  // a line each, without line breaks
};

// Lines: title, the columns of the thesis, a bar, ours, and the remarks, broken at 120 characters.
std::string to_text(const Comparison& comparison);
nlohmann::ordered_json to_json(const Comparison& comparison);

}  // namespace coppice
