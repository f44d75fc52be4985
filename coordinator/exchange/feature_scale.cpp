#include "coordinator/exchange/feature_scale.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numeric>

namespace coppice {
namespace {

bool is_name_character(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
}

bool is_code(double reading) { return reading >= 0.0 && reading <= 255.0 && reading == std::floor(reading); }

void number_values(std::size_t count, Feature& feature) {
  feature.values.resize(count);
  std::iota(feature.values.begin(), feature.values.end(), std::uint8_t{0});
}

}  // namespace

void DistinctReadings::insert(double reading) {
  values_.insert(reading == 0.0 ? 0.0 : reading);  // -0 is 0
  if (values_.size() > kMaxValues) {
    too_many_ = true;
    values_.clear();
  }
}

std::vector<std::string> legal_names(const std::vector<std::string>& names, const std::string& prefix) {
  constexpr std::size_t kKept = kMaxNameLength - 8;  // room for a number
  std::set<std::string> taken{"sequence", "selector"};
  std::vector<std::string> legal;
  for (const std::string& name : names) {
    std::string text;
    for (const char c : name) {
      text += is_name_character(c) ? c : '_';
    }
    // "(right)" is right, "x (m)" is x_m.
    const std::size_t first = text.find_first_not_of('_');
    const bool inner = first != std::string::npos && !is_name_character(name.front());
    text = inner ? text.substr(first, text.find_last_not_of('_') - first + 1) : text;
    const bool headless = text.empty() || (text.front() >= '0' && text.front() <= '9');
    if (headless) {
      text.insert(0, prefix);
    }
    text.resize(std::min(text.size(), kKept));
    std::string unique = text;
    for (std::size_t number = 2; !taken.insert(unique).second; ++number) {
      unique = fmt::format("{}_{}", text, number);
    }
    legal.push_back(unique);
  }
  return legal;
}

Result<Feature> feature_of(const std::string& name, const DistinctReadings& distinct, const FeatureWish& wish,
                           const Binning& otherwise, const EdgesOf& edges_of) {
  Feature feature;
  feature.name = name;
  const Binning binning = wish.binning.value_or(distinct.too_many() ? otherwise : Binning{});
  if (binning.kind != Binning::Kind::none) {
    if (wish.admits_equal.value_or(false)) {
      return bad_input(fmt::format("feature '{}' has bins: expected the operator <= only", name));
    }
    auto edges = edges_of(binning);
    if (!edges) {
      return in_context(fmt::format("feature '{}'", name), edges.error());
    }
    feature.scale = Scale::bins;
    feature.numbers = std::move(*edges);
    number_values(feature.numbers.size() + 1, feature);
    feature.admits_equal = false;
    feature.admits_less_equal = true;
    return feature;
  }
  if (distinct.too_many()) {
    return bad_input(
        fmt::format("feature '{}' has more than {} different readings: expected bins, as in a problem file "
                    "[features.{}] bins = {{ quantiles = 8 }}",
                    name, kMaxValues, name));
  }
  const auto& readings = distinct.values();
  if (std::all_of(readings.begin(), readings.end(), is_code)) {
    for (const double reading : readings) {
      feature.values.push_back(static_cast<std::uint8_t>(reading));
    }
  } else {
    feature.scale = Scale::numbers;
    feature.numbers.assign(readings.begin(), readings.end());
    number_values(feature.numbers.size(), feature);
  }
  feature.admits_equal = wish.admits_equal.value_or(true);
  feature.admits_less_equal = wish.admits_less_equal.value_or(readings.size() > 2);
  return feature;
}

Result<FeatureLegend> legend_of(const Feature& feature, const FeatureWish& wish) {
  FeatureLegend legend;
  legend.label = wish.label.substr(0, kMaxLabel);
  legend.unit = wish.unit.substr(0, kMaxLabel);
  for (const auto& [reading, label] : wish.values) {
    const std::optional<std::uint8_t> value =
        feature.scale == Scale::bins ? std::nullopt : feature.value_of(reading == 0.0 ? 0.0 : reading);
    if (value) {  // a reading that never came needs no label
      legend.values[*value] = label.substr(0, kMaxLabel);
    } else if (feature.scale == Scale::bins) {
      return bad_input(fmt::format("feature '{}' has bins: expected no labels of values", feature.name));
    }
  }
  return legend;
}

}  // namespace coppice
