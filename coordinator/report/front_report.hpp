// A front of trees for people and programs: a table and JSON. Pure functions of the front.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/error.hpp"
#include "common/tree/vocabulary.hpp"
#include "coordinator/evolution/pick.hpp"
#include "coordinator/report/score.hpp"

namespace coppice {

// Whether it lies in [0, 1] and is shown in percent.
bool is_share(Measure measure);

// One value as people read it: shares in percent, the others with the digits that tell.
std::string measure_text(Measure measure, double value);

// A line a tree: its number on the front (from 0), every measure, what it did in the simulator, fitness; `picked` is
// marked. simulated: [members], or empty: it was not tried there.
std::string to_text(const Front& front, std::optional<std::size_t> picked,
                    const std::vector<ControllerScore>& simulated = {});

// A list of objects on one line: number, fitness, each measure, "simulated", tree.
std::string to_json(const Front& front, const Vocabulary& vocabulary, std::optional<std::size_t> picked,
                    const std::vector<ControllerScore>& simulated = {});

}  // namespace coppice
