// A tree in every format that a person can take away from the studio.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "common/error.hpp"
#include "common/tree/tree.hpp"
#include "coordinator/study/study.hpp"

namespace coppice {

// [{"format", "what"}], by name.
nlohmann::ordered_json export_formats();

// {"name": of the file, "text"}. Errors: no such format; what the format cannot say, by name.
// REQUIRES: check_tree(tree, study.chain().vocabulary()).
Result<nlohmann::ordered_json> export_tree(const Tree& tree, const Study& study, const std::string& format);

}  // namespace coppice
