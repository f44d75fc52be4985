#include "coordinator/exchange/source_header.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "coordinator/exchange/text_number.hpp"
#include "coordinator/problem/problem.hpp"

namespace coppice {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kMaxNames = 4096;  // of features or actions; what a chain takes is less and checked later

Result<std::string> text_of(const std::string& key, const Json& value) {
  if (!value.is_string() || value.get_ref<const std::string&>().size() > kMaxSimulatorCommand) {
    return bad_input(fmt::format("\"{}\": expected a text of at most {} characters", key, kMaxSimulatorCommand));
  }
  return value.get<std::string>();
}

Result<void> text_into(const std::string& key, const Json& object, const char* member, std::string& into) {
  const auto found = object.find(member);
  if (found == object.end() || found->is_null()) {
    return {};
  }
  auto text = text_of(key + "." + member, *found);
  if (!text) {
    return tl::unexpected(text.error());
  }
  into = std::move(*text);
  return {};
}

// The name of an entry that is a name or an object with one.
Result<std::string> name_of_entry(const std::string& key, const Json& entry) {
  const Json& name = entry.is_object() && entry.contains("name") ? entry["name"] : entry;
  if (name.is_number_integer()) {
    return name.dump();
  }
  return text_of(key, name);
}

Result<void> read_feature(const Json& entry, SourceHeader& header) {
  const std::string key = fmt::format("features[{}]", header.features.size());
  auto name = name_of_entry(key, entry);
  if (!name) {
    return tl::unexpected(name.error());
  }
  header.features.push_back(std::move(*name));
  FeatureWish& legend = header.legends.emplace_back();
  if (!entry.is_object()) {
    return {};
  }
  for (const auto& [member, into] : {std::pair{"label", &legend.label}, std::pair{"unit", &legend.unit}}) {
    if (auto ok = text_into(key, entry, member, *into); !ok) {
      return ok;
    }
  }
  const auto values = entry.find("values");
  if (values == entry.end() || values->is_null()) {
    return {};
  }
  if (!values->is_object()) {
    return bad_input(fmt::format("\"{}.values\": expected an object of labels by value", key));
  }
  for (const auto& [value, label] : values->items()) {
    const auto reading = to_double(value);
    const auto text = text_of(fmt::format("{}.values.{}", key, value), label);
    if (!reading || !text) {
      return reading ? Result<void>(tl::unexpected(text.error()))
                     : bad_input(fmt::format("\"{}.values.{}\": expected a number as key", key, value));
    }
    legend.values[*reading] = *text;
  }
  return {};
}

Result<void> read_action(const Json& entry, SourceHeader& header) {
  const std::string key = fmt::format("actions[{}]", header.actions.size());
  auto name = name_of_entry(key, entry);
  if (!name) {
    return tl::unexpected(name.error());
  }
  header.actions.push_back(std::move(*name));
  ActionWish& legend = header.action_legends.emplace_back();
  return entry.is_object() ? text_into(key, entry, "label", legend.label) : Result<void>();
}

}  // namespace

std::string shown(const Json& value) {
  constexpr std::size_t kShown = 40;  // characters
  if (value.is_structured()) {
    return value.is_array() ? "a list" : "an object";
  }
  return value.dump(-1, ' ', false, Json::error_handler_t::replace).substr(0, kShown);
}

Result<bool> read_header_member(const std::string& key, const Json& value, SourceHeader& header) {
  if (key == "title" || key == "simulator") {
    auto text = text_of(key, value);
    if (!text) {
      return tl::unexpected(text.error());
    }
    (key == "title" ? header.title : header.simulator) = std::move(*text);
    return true;
  }
  if (key == "discount") {
    const double discount = value.is_number() ? value.get<double>() : -1.0;
    if (!value.is_null() && !(discount >= 0.0 && discount <= 1.0)) {
      return bad_input("\"discount\": expected a number from 0 to 1");
    }
    header.discount = value.is_null() ? std::nullopt : std::optional(discount);
    return true;
  }
  if (key != "features" && key != "actions") {
    return false;
  }
  if (!value.is_array() || value.size() > kMaxNames) {
    return bad_input(fmt::format("\"{}\": expected a list of at most {} names", key, kMaxNames));
  }
  for (const Json& entry : value) {
    auto ok = key == "features" ? read_feature(entry, header) : read_action(entry, header);
    if (!ok) {
      return tl::unexpected(ok.error());
    }
  }
  return true;
}

void fill_from_header(const SourceHeader& header, ProblemFile& file) {
  file.title = file.title.empty() ? header.title : file.title;
  file.simulator = file.simulator.empty() ? header.simulator : file.simulator;
  file.discount = file.discount ? file.discount : header.discount;
  for (std::size_t f = 0; f < header.features.size(); ++f) {
    FeatureWish& wish = file.features[header.features[f]];
    const FeatureWish& legend = header.legends[f];
    wish.label = wish.label.empty() ? legend.label : wish.label;
    wish.unit = wish.unit.empty() ? legend.unit : wish.unit;
    // Bins have no labelled values, whatever the source says of single readings.
    const bool binned = wish.binning && wish.binning->kind != Binning::Kind::none;
    wish.values = wish.values.empty() && !binned ? legend.values : wish.values;
  }
  for (std::size_t a = 0; a < header.actions.size(); ++a) {
    ActionWish& wish = file.actions[header.actions[a]];
    wish.label = wish.label.empty() ? header.action_legends[a].label : wish.label;
  }
}

}  // namespace coppice
