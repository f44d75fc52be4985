#include "coordinator/problem/problem.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "common/check.hpp"

namespace coppice {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMaxSource = 4096;  // characters

// Reads members of one JSON object; `where` names it in messages.
class Members {
 public:
  Members(const Json& object, std::string where) : object_(object), where_(std::move(where)) {}

  Result<std::string> text(const char* key, std::size_t most) const {
    const auto found = object_.find(key);
    if (found == object_.end()) {
      return std::string();
    }
    if (!found->is_string() || found->get_ref<const std::string&>().size() > most) {
      return bad_input(fmt::format("{}.{}: expected a text of at most {} characters", where_, key, most));
    }
    return found->get<std::string>();
  }

  // An empty one where there is none.
  Result<Json> object(const char* key) const {
    const auto found = object_.find(key);
    if (found == object_.end()) {
      return Json::object();
    }
    if (!found->is_object()) {
      return bad_input(fmt::format("{}.{}: expected an object", where_, key));
    }
    return *found;
  }

 private:
  const Json& object_;
  std::string where_;
};

Json json_of(const FeatureLegend& legend, const Feature& feature) {
  Json json = Json::object();
  if (!legend.label.empty()) {
    json["label"] = legend.label;
  }
  if (!legend.unit.empty()) {
    json["unit"] = legend.unit;
  }
  for (const auto& [value, label] : legend.values) {
    json["values"][feature.number_text(value)] = label;
  }
  return json;
}

Result<FeatureLegend> legend_of(const Json& json, const Feature& feature) {
  const std::string where = fmt::format("problem.features.{}", feature.name);
  if (!json.is_object()) {
    return bad_input(where + ": expected an object");
  }
  const Members members(json, where);
  FeatureLegend legend;
  for (const auto& [key, into] : {std::pair{"label", &legend.label}, std::pair{"unit", &legend.unit}}) {
    auto text = members.text(key, kMaxLabel);
    if (!text) {
      return tl::unexpected(text.error());
    }
    *into = std::move(*text);
  }
  const auto values = members.object("values");
  if (!values) {
    return tl::unexpected(values.error());
  }
  const Members labels(*values, where + ".values");
  for (const auto& [key, label] : values->items()) {
    const std::optional<std::uint8_t> value = feature.value_of_text(key);
    if (!value) {
      return bad_input(fmt::format("{}.values.{}: the feature does not read this: expected one of {}", where, key,
                                   feature.values_text()));
    }
    auto text = labels.text(key.c_str(), kMaxLabel);
    if (!text) {
      return tl::unexpected(text.error());
    }
    legend.values[*value] = std::move(*text);
  }
  return legend;
}

Result<std::vector<std::string>> rules_of(const Json& json) {
  std::vector<std::string> rules;
  const auto found = json.find("rules");
  if (found == json.end()) {
    return rules;
  }
  const auto is_rule = [](const Json& rule) {
    return rule.is_string() && rule.get_ref<const std::string&>().size() <= kMaxRule;
  };
  if (!found->is_array() || found->size() > kMaxRules || !std::all_of(found->begin(), found->end(), is_rule)) {
    return bad_input(
        fmt::format("problem.rules: expected a list of at most {} texts of {} characters", kMaxRules, kMaxRule));
  }
  for (const Json& rule : *found) {
    rules.push_back(rule.get<std::string>());
  }
  return rules;
}

Result<void> read_features(const Json& features, const Vocabulary& vocabulary, Problem& problem) {
  for (const auto& [name, json] : features.items()) {
    const std::optional<std::size_t> index = vocabulary.find_feature(name);
    if (!index) {
      return bad_input(fmt::format("problem.features.{}: there is no such feature", name));
    }
    auto legend = legend_of(json, vocabulary.features[*index]);
    if (!legend) {
      return tl::unexpected(legend.error());
    }
    problem.features[*index] = std::move(*legend);
  }
  return {};
}

Result<void> read_actions(const Json& actions, const Vocabulary& vocabulary, Problem& problem) {
  const Members members(actions, "problem.actions");
  for (const auto& [name, json] : actions.items()) {
    const std::optional<ActionId> action = vocabulary.find_action(name);
    if (!action) {
      return bad_input(fmt::format("problem.actions.{}: there is no such action", name));
    }
    auto text = members.text(name.c_str(), kMaxLabel);
    if (!text) {
      return tl::unexpected(text.error());
    }
    problem.action_labels[index_of(*action)] = std::move(*text);
  }
  return {};
}

}  // namespace

Problem unlabelled(const Vocabulary& vocabulary) {
  Problem problem;
  problem.features.resize(vocabulary.features.size());
  problem.action_labels.resize(vocabulary.actions.size());
  return problem;
}

std::string to_json(const Problem& problem, const Vocabulary& vocabulary) {
  COPPICE_CHECK(problem.features.size() == vocabulary.features.size() &&
                problem.action_labels.size() == vocabulary.actions.size());
  Json json = Json::object();
  for (const auto& [key, text] : {std::pair{"title", &problem.title}, std::pair{"source", &problem.source},
                                  std::pair{"simulator", &problem.simulator}}) {
    if (!text->empty()) {
      json[key] = *text;
    }
  }
  if (problem.discount) {
    json["discount"] = *problem.discount;
  }
  if (!problem.rules.empty()) {
    json["rules"] = problem.rules;
  }
  for (std::size_t f = 0; f < vocabulary.features.size(); ++f) {
    if (problem.features[f] != FeatureLegend{}) {
      json["features"][vocabulary.features[f].name] = json_of(problem.features[f], vocabulary.features[f]);
    }
  }
  for (std::size_t a = 0; a < vocabulary.actions.size(); ++a) {
    if (!problem.action_labels[a].empty()) {
      json["actions"][vocabulary.actions[a]] = problem.action_labels[a];
    }
  }
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Result<Problem> problem_from_json(std::string_view text, const Vocabulary& vocabulary) {
  const Json json = Json::parse(text, nullptr, false);
  if (!json.is_object()) {
    return bad_input("problem: expected a JSON object");
  }
  Problem problem = unlabelled(vocabulary);
  const Members members(json, "problem");
  struct Text {
    const char* key;
    std::string* into;
    std::size_t most;
  };
  for (const Text& field : {Text{"title", &problem.title, kMaxLabel}, Text{"source", &problem.source, kMaxSource},
                            Text{"simulator", &problem.simulator, kMaxSimulatorCommand}}) {
    auto read = members.text(field.key, field.most);
    if (!read) {
      return tl::unexpected(read.error());
    }
    *field.into = std::move(*read);
  }
  if (const auto discount = json.find("discount"); discount != json.end()) {
    const double value = discount->is_number() ? discount->get<double>() : -1.0;
    if (!(value >= 0.0 && value <= 1.0)) {
      return bad_input("problem.discount: expected a number from 0 to 1");
    }
    problem.discount = value;
  }
  auto rules = rules_of(json);
  if (!rules) {
    return tl::unexpected(rules.error());
  }
  problem.rules = std::move(*rules);
  const auto features = members.object("features");
  const auto actions = members.object("actions");
  if (!features || !actions) {
    return tl::unexpected(features ? actions.error() : features.error());
  }
  if (auto ok = read_features(*features, vocabulary, problem); !ok) {
    return tl::unexpected(ok.error());
  }
  if (auto ok = read_actions(*actions, vocabulary, problem); !ok) {
    return tl::unexpected(ok.error());
  }
  return problem;
}

std::string in_words(const Node& node, const Problem& problem, const Vocabulary& vocabulary) {
  if (node.kind == NodeKind::action) {
    return problem.action_labels[node.index];
  }
  if (node.kind != NodeKind::condition) {
    return {};
  }
  const FeatureLegend& legend = problem.features[node.index];
  const auto label = legend.values.find(node.value);
  if (legend.label.empty() && legend.unit.empty() && label == legend.values.end()) {
    return {};
  }
  const Feature& feature = vocabulary.features[node.index];
  const std::string name = legend.label.empty() ? feature.name : legend.label;
  const std::string unit = legend.unit.empty() ? "" : " " + legend.unit;
  const std::string number = feature.number_text(node.value) + unit;
  if (node.op == Op::equal) {
    return fmt::format("{} is {}", name, label == legend.values.end() ? number : label->second);
  }
  return fmt::format("{} is at most {}", name,
                     label == legend.values.end() ? number : fmt::format("{} ({})", number, label->second));
}

}  // namespace coppice
