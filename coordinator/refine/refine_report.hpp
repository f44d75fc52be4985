// The rounds of a refinement as people and programs read them.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "coordinator/refine/refine.hpp"

namespace coppice {

// A table, a line a round, and what its columns mean.
std::string to_text(const std::vector<RefineRound>& rounds);
nlohmann::ordered_json to_json(const std::vector<RefineRound>& rounds);

}  // namespace coppice
