#include "common/evolution/measure.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "common/check.hpp"
#include "common/tree/tree_size.hpp"

namespace coppice {
namespace {

constexpr std::string_view kNodesName = "nodes";
constexpr std::string_view kConditionsName = "conditions";

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(" \t");
  if (begin == std::string_view::npos) {
    return {};
  }
  return text.substr(begin, text.find_last_not_of(" \t") - begin + 1);
}

// Measured a walk rather than a step.
bool per_walk(ObjectiveKind kind) {
  return kind == ObjectiveKind::expected_return || kind == ObjectiveKind::collisions || kind == ObjectiveKind::unknown;
}

}  // namespace

std::string_view name_of(Measure measure) {
  return is_objective(measure) ? name_of(kind_of(measure)) : measure == kNodesMeasure ? kNodesName : kConditionsName;
}

Result<Measure> measure_named(std::string_view name) {
  std::vector<std::string_view> names;
  for (std::uint8_t m = 0; m < kMeasures; ++m) {
    if (name_of(Measure{m}) == name) {
      return Measure{m};
    }
    names.push_back(name_of(Measure{m}));
  }
  return bad_input(fmt::format("no measure '{}': expected one of {}", name, fmt::join(names, ", ")));
}

Result<std::vector<Measure>> measures_from(std::string_view text) {
  std::vector<Measure> measures;
  for (bool more = true; more;) {
    const std::size_t comma = text.find(',');
    const auto measure = measure_named(trimmed(text.substr(0, comma)));
    if (!measure) {
      return tl::unexpected(measure.error());
    }
    if (std::find(measures.begin(), measures.end(), *measure) != measures.end()) {
      return bad_input(fmt::format("'{}' is named twice: expected distinct measures", name_of(*measure)));
    }
    measures.push_back(*measure);
    more = comma != std::string_view::npos;
    text.remove_prefix(more ? comma + 1 : text.size());
  }
  return measures;
}

std::string to_text(std::span<const Measure> measures) {
  std::string text;
  for (const Measure measure : measures) {
    text += fmt::format("{}{}", text.empty() ? "" : ", ", name_of(measure));
  }
  return text;
}

Result<Measuring> Measuring::make(const Chain& chain, const std::vector<Objective>& objectives, std::uint32_t steps) {
  Measuring result;
  result.steps_ = steps;
  for (const Objective& objective : objectives) {
    result.measures_.push_back(measure_of(objective.kind));
    double scale = 1.0;
    if (objective.kind != ObjectiveKind::agreement) {
      const auto table = make_score_table(chain, objective);
      if (!table) {
        return tl::unexpected(table.error());
      }
      const bool share = !along_walk(objective.kind) && !is_cost(objective.kind);
      scale = 1.0 / (share ? static_cast<double>(table->best_per_step) : table->unit);
    }
    result.scale_.push_back(scale);
  }
  COPPICE_CHECK(std::is_sorted(result.measures_.begin(), result.measures_.end()));
  result.measures_.push_back(kNodesMeasure);
  result.measures_.push_back(kConditionsMeasure);
  return result;
}

std::vector<double> Measuring::values(const Tree& tree, const Tally& tally) const {
  COPPICE_CHECK(tally.scores.size() == scale_.size() && tally.steps > 0);
  std::vector<double> values;
  values.reserve(measures_.size());
  for (std::size_t i = 0; i < scale_.size(); ++i) {
    const ObjectiveKind kind = kind_of(measures_[i]);
    double value = static_cast<double>(tally.scores[i]) * scale_[i];
    if (along_walk(kind)) {
      value = value / static_cast<double>(tally.steps) * (per_walk(kind) ? steps_ : 1.0);
    }
    values.push_back(value);
  }
  values.push_back(static_cast<double>(tree.size()));
  values.push_back(static_cast<double>(condition_count(tree.nodes())));
  return values;
}

double Measuring::slope(std::size_t objective) const {
  return scale_[objective] * (per_walk(kind_of(measures_[objective])) ? steps_ : 1.0);
}

}  // namespace coppice
