// What a run of evolution came to, in words and as JSON.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "coordinator/runs/evolve_in_study.hpp"

namespace coppice {

// Lines.
std::string to_text(const EvolveReport& report, const Study& study);
// One object on one line.
std::string to_json(const EvolveReport& report, const Study& study);
// The figures that are kept with the run in its study; what a repetition with the same seed repeats, but for seconds
// and dispatch.
nlohmann::ordered_json outcome_json(const EvolveReport& report);

}  // namespace coppice
