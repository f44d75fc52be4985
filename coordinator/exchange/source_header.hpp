// What sources of our own making (P tables, logs) say about themselves beside their numbers: names, labels and units.
// A plain value.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/error.hpp"
#include "coordinator/exchange/problem_file.hpp"

namespace coppice {

struct SourceHeader {
  std::string title;
  std::vector<std::string> features;  // names, in the order of observations; empty: not said
  std::vector<FeatureWish> legends;   // [features]
  std::vector<std::string> actions;   // names, by index; empty: not said
  std::vector<ActionWish> action_legends;
  std::optional<double> discount;
  std::string simulator;
};

// Takes the member `key` of a source into the header; false: it is none of the header's. Errors name the key, what was
// found and what was expected.
//   "title": TEXT, "simulator": TEXT, "discount": NUMBER,
//   "features": [NAME or {"name", "label", "unit", "values": {"0": LABEL}}], "actions": [NAME or {"name", "label"}]
Result<bool> read_header_member(const std::string& key, const nlohmann::json& value, SourceHeader& header);

// A JSON value in a message: short values as they are, lists and objects by their kind (they may be deep).
std::string shown(const nlohmann::json& value);

// What the header says counts where the problem file says nothing.
void fill_from_header(const SourceHeader& header, ProblemFile& file);

}  // namespace coppice
