#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "common/evolution/config_keys.hpp"
#include "coordinator/evolution/config_text.hpp"

namespace coppice {
namespace {

using Json = nlohmann::ordered_json;

Json json_of(const ConfigKey& key) {
  return std::visit(
      [](const auto& value) -> Json {
        if constexpr (std::is_same_v<std::decay_t<decltype(value)>, OtherValue>) {
          return nullptr;
        } else {
          return value;
        }
      },
      value_of(key));
}

ConfigValue value_of(const Json& json) {
  switch (json.type()) {
    case Json::value_t::number_integer:
      return json.get<std::int64_t>();
    case Json::value_t::number_unsigned:
      return json.get<std::uint64_t>();
    case Json::value_t::number_float:
      return json.get<double>();
    case Json::value_t::string:
      return json.get<std::string>();
    default:
      return OtherValue{std::string("a JSON ") + json.type_name()};
  }
}

Result<void> assign_all(const Json& object, std::string_view section, const std::vector<ConfigKey>& keys) {
  for (const auto& [name, value] : object.items()) {
    if ((section == "fitness" && name == kRuleKey) || (section == "fitness.rule" && name == kAnyOfKey) ||
        (section.empty() && is_section(keys, name))) {
      continue;
    }
    const auto key = find_key(keys, section, name);
    if (!key) {
      return tl::unexpected(key.error());
    }
    if (auto ok = assign(**key, value_of(value)); !ok) {
      return ok;
    }
  }
  return {};
}

Result<RuleConfig> rule_of(const Json& json) {
  RuleConfig rule;
  if (!json.is_object()) {
    return bad_input("fitness.rule: expected a list of objects");
  }
  if (auto ok = assign_all(json, "fitness.rule", keys_of(rule)); !ok) {
    return tl::unexpected(ok.error());
  }
  const Json conditions = json.value(std::string(kAnyOfKey), Json::array());
  if (!conditions.is_array()) {
    return bad_input("fitness.rule.any_of: expected a list of strings");
  }
  for (const Json& condition : conditions) {
    if (!condition.is_string()) {
      return bad_input("fitness.rule.any_of: expected a list of strings");
    }
    rule.any_of.push_back(condition.get<std::string>());
  }
  return rule;
}

}  // namespace

std::string config_to_json(const EvolveConfig& config) {
  EvolveConfig copy = config;
  Json root;
  for (const ConfigKey& key : keys_of(copy)) {
    (key.section.empty() ? root[key.name] : root[key.section][key.name]) = json_of(key);
  }
  Json& rules = root["fitness"][std::string(kRuleKey)] = Json::array();
  for (RuleConfig& rule : copy.fitness.rules) {
    Json json;
    json[std::string(kAnyOfKey)] = rule.any_of;
    for (const ConfigKey& key : keys_of(rule)) {
      json[key.name] = json_of(key);
    }
    rules.push_back(std::move(json));
  }
  return root.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Result<EvolveConfig> config_from_json(std::string_view text) {
  const Json root = Json::parse(text, nullptr, false);
  if (!root.is_object()) {
    return bad_input("configuration: expected a JSON object");
  }
  EvolveConfig config;
  const std::vector<ConfigKey> keys = keys_of(config);
  if (auto ok = assign_all(root, "", keys); !ok) {
    return tl::unexpected(ok.error());
  }
  for (const auto& [name, section] : root.items()) {
    if (!is_section(keys, name)) {
      continue;
    }
    if (!section.is_object()) {
      return bad_input(fmt::format("{}: expected a JSON object", name));
    }
    if (auto ok = assign_all(section, name, keys); !ok) {
      return tl::unexpected(ok.error());
    }
    const auto rules = section.find(std::string(kRuleKey));
    if (name != "fitness" || rules == section.end()) {
      continue;
    }
    if (!rules->is_array()) {
      return bad_input("fitness.rule: expected a list of objects");
    }
    for (const Json& json : *rules) {
      auto rule = rule_of(json);
      if (!rule) {
        return tl::unexpected(rule.error());
      }
      config.fitness.rules.push_back(std::move(*rule));
    }
  }
  return config;
}

}  // namespace coppice
