// What a study remembers: how its policy was learned, its runs with their generations, their fronts, and how each of
// them can be made again. Reads the study; no other files.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "common/error.hpp"
#include "coordinator/study/study.hpp"

namespace coppice {

// A curve of more generations is thinned out: every so many'th, the last included, which the page says.
inline constexpr std::size_t kMostPageGenerations = 1000;
inline constexpr std::size_t kMostPageDemeGenerations = 300;  // of each deme

// [runs] with their generations and fronts. Fields: README.md, "runs". Errors: the study's.
Result<nlohmann::ordered_json> runs_json(const Study& study);

// {"settings", "outcome"} of learning, as the study keeps them; what is not JSON there becomes null.
nlohmann::ordered_json learning_json(const Study& study);

// The command that learned this study, as far as its settings say; empty: they do not.
std::string learn_command(const Study& study);
// "coppice evolve STUDY --seed 28 --set fitness.return=1".
std::string evolve_command(const Study& study, const RunRecord& run);

}  // namespace coppice
