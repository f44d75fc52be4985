// A front of trees for people and programs: a table, JSON, and a drawing of two of its measures. Pure functions of the
// front; the drawing needs no other program.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/error.hpp"
#include "common/tree/vocabulary.hpp"
#include "coordinator/evolution/pick.hpp"

namespace coppice {

// One value as people read it: shares in percent, the others with the digits that tell.
std::string measure_text(Measure measure, double value);

// A line a tree: its number on the front (from 0), every measure, fitness; `picked` is marked.
std::string to_text(const Front& front, std::optional<std::size_t> picked);

// A list of objects on one line: number, fitness, each measure, tree.
std::string to_json(const Front& front, const Vocabulary& vocabulary, std::optional<std::size_t> picked);

struct FrontAxes {
  Measure across{};
  Measure up{};
};

// "coverage,return". Errors: not two measures, or one that the front does not have.
Result<FrontAxes> axes_from(std::string_view text, const Front& front);

// SVG: a dot a tree, the smaller the lighter, with its nodes as a title; those that nothing beats in these two measures
// are joined. REQUIRES: front.members not empty, axes of its measures.
std::string front_svg(const Front& front, const FrontAxes& axes, std::optional<std::size_t> picked);

}  // namespace coppice
