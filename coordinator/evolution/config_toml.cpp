#include <cerrno>
#include <charconv>
#include <cstring>
#include <fmt/format.h>
#include <fstream>
#include <iterator>
#include <system_error>

#include "common/evolution/config_keys.hpp"
#include "common/toml.hpp"
#include "coordinator/evolution/config_text.hpp"

namespace coppice {
namespace {

constexpr std::size_t kMaxConfigBytes = std::size_t{1} << 20U;

std::string type_name(const toml::node& node) {
  switch (node.type()) {
    case toml::node_type::table:
      return "a table";
    case toml::node_type::array:
      return "a list";
    case toml::node_type::boolean:
      return *node.value_exact<bool>() ? "true" : "false";
    case toml::node_type::integer:
      return fmt::format("{}", *node.value_exact<std::int64_t>());
    case toml::node_type::floating_point:
      return fmt::format("{}", *node.value_exact<double>());
    case toml::node_type::string:
      return fmt::format("\"{}\"", *node.value_exact<std::string>());
    default:
      return "a date or time";
  }
}

ConfigValue value_of(const toml::node& node) {
  if (const auto integer = node.value_exact<std::int64_t>()) {
    return *integer;
  }
  if (const auto real = node.value_exact<double>()) {
    return *real;
  }
  if (auto text = node.value_exact<std::string>()) {
    return std::move(*text);
  }
  return OtherValue{type_name(node)};
}

// Reads one file into a configuration; every error names the file and the line.
class TomlReader {
 public:
  TomlReader(const std::string& name, EvolveConfig& config) : name_(name), config_(config), keys_(keys_of(config)) {}

  // How many keys it set.
  Result<std::size_t> read(const toml::table& root) {
    for (const auto& [key, node] : root) {
      auto ok = is_section(keys_, key.str()) ? read_section(key.str(), node) : read_value("", key, node);
      if (!ok) {
        return tl::unexpected(std::move(ok).error());
      }
    }
    return keys_set_;
  }

 private:
  tl::unexpected<Error> at(const toml::source_region& place, Error error) const {
    return in_context(fmt::format("{}: line {}", name_, place.begin.line), std::move(error));
  }

  Result<void> read_section(std::string_view section, const toml::node& node) {
    const toml::table* table = node.as_table();
    if (table == nullptr) {
      return at(node.source(), {ErrorKind::bad_input,
                                fmt::format("{} is {}: expected a table [{}]", section, type_name(node), section)});
    }
    for (const auto& [key, value] : *table) {
      auto ok = section == "fitness" && key.str() == kRuleKey ? read_rules(value) : read_value(section, key, value);
      if (!ok) {
        return ok;
      }
    }
    return {};
  }

  Result<void> read_value(std::string_view section, const toml::key& key, const toml::node& node) {
    const auto found = find_key(keys_, section, key.str());
    if (!found) {
      return at(key.source(), found.error());
    }
    auto ok = assign(**found, value_of(node));
    ++keys_set_;
    return ok ? Result<void>() : at(node.source(), ok.error());
  }

  Result<void> read_rules(const toml::node& node) {
    const toml::array* array = node.as_array();
    if (array == nullptr || (!array->empty() && !array->is_homogeneous(toml::node_type::table))) {
      return at(node.source(), {ErrorKind::bad_input, "fitness.rule: expected tables [[fitness.rule]]"});
    }
    ++keys_set_;
    config_.fitness.rules.clear();
    for (const toml::node& element : *array) {
      RuleConfig rule;
      if (auto ok = read_rule(*element.as_table(), rule); !ok) {
        return ok;
      }
      config_.fitness.rules.push_back(std::move(rule));
    }
    return {};
  }

  Result<void> read_rule(const toml::table& table, RuleConfig& rule) const {
    const std::vector<ConfigKey> keys = keys_of(rule);
    for (const auto& [key, node] : table) {
      if (key.str() == kAnyOfKey) {
        const toml::array* array = node.as_array();
        if (array == nullptr) {
          return at(node.source(), any_of_expected());
        }
        for (const toml::node& element : *array) {
          auto text = element.value_exact<std::string>();
          if (!text) {
            return at(element.source(), any_of_expected());
          }
          rule.any_of.push_back(std::move(*text));
        }
        continue;
      }
      const auto found = find_key(keys, "fitness.rule", key.str());
      if (!found) {
        return at(key.source(), found.error());
      }
      if (auto ok = assign(**found, value_of(node)); !ok) {
        return at(node.source(), ok.error());
      }
    }
    return {};
  }

  static Error any_of_expected() {
    return {ErrorKind::bad_input, "fitness.rule.any_of: expected a list of conditions such as [\"s3=3\", \"s4=3\"]"};
  }

  const std::string& name_;
  EvolveConfig& config_;
  std::vector<ConfigKey> keys_;
  std::size_t keys_set_ = 0;
};

// How many keys it set; with an error `config` stays as it was.
Result<std::size_t> read_text(std::string_view toml, const std::string& name, EvolveConfig& config) {
  if (toml.size() > kMaxConfigBytes) {
    return bad_input(fmt::format("{}: {} bytes: expected at most {}", name, toml.size(), kMaxConfigBytes));
  }
  const Result<toml::table> root = parse_toml(toml, name);
  if (!root) {
    return tl::unexpected(root.error());
  }
  EvolveConfig changed = config;
  Result<std::size_t> keys_set = TomlReader(name, changed).read(*root);
  if (keys_set) {
    config = std::move(changed);
  }
  return keys_set;
}

ConfigValue value_of(std::string_view text) {
  const char* end = text.data() + text.size();
  std::int64_t narrow = 0;
  if (const auto [stop, error] = std::from_chars(text.data(), end, narrow); stop == end && error == std::errc()) {
    return narrow;
  }
  std::uint64_t wide = 0;
  if (const auto [stop, error] = std::from_chars(text.data(), end, wide); stop == end && error == std::errc()) {
    return wide;
  }
  double real = 0.0;
  if (text.find_first_of(".eE") != std::string_view::npos) {
    if (const auto [stop, error] = std::from_chars(text.data(), end, real); stop == end && error == std::errc()) {
      return real;
    }
  }
  return std::string(text);
}

}  // namespace

Result<void> read_config(std::string_view toml, const std::string& name, EvolveConfig& config) {
  return read_text(toml, name, config).map([](std::size_t) {});
}

Result<void> load_config(const std::string& path, EvolveConfig& config) {
  std::ifstream file(path, std::ios::binary);
  std::string text;
  if (file) {
    text.resize(kMaxConfigBytes + 1);
    file.read(text.data(), static_cast<std::streamsize>(text.size()));
    text.resize(static_cast<std::size_t>(file.gcount()));
  }
  if (file.bad() || (text.empty() && !file.eof())) {
    return bad_input(fmt::format("{}: cannot be read: {}", path, std::strerror(errno)));
  }
  const Result<std::size_t> keys_set = read_text(text, path, config);
  if (!keys_set) {
    return tl::unexpected(keys_set.error());
  }
  if (*keys_set == 0) {  // another file by mistake, or one that is still to be written
    return bad_input(fmt::format("{}: sets no key: expected at least one, such as ga.population = 200", path));
  }
  return {};
}

Result<void> assign_text(std::string_view name, std::string_view value, EvolveConfig& config) {
  const std::size_t dot = name.find('.');
  const std::string_view section = dot == std::string_view::npos ? std::string_view() : name.substr(0, dot);
  const std::string_view key = dot == std::string_view::npos ? name : name.substr(dot + 1);
  const std::vector<ConfigKey> keys = keys_of(config);
  if (section == "fitness" && key == kRuleKey) {
    return bad_input("rules can be given only in a file, as [[fitness.rule]]");
  }
  const auto found = is_section(keys, section) ? find_key(keys, section, key) : find_key(keys, "", name);
  return found ? assign(**found, value_of(value)) : tl::unexpected(found.error());
}

Result<void> apply_setting(std::string_view assignment, EvolveConfig& config) {
  const std::string place = fmt::format("--set {}", assignment);
  const std::size_t equals = assignment.find('=');
  if (equals == std::string_view::npos) {
    return bad_input(place + ": expected KEY=VALUE, such as ga.population=200");
  }
  const auto ok = assign_text(assignment.substr(0, equals), assignment.substr(equals + 1), config);
  return ok ? Result<void>() : in_context(place, ok.error());
}

}  // namespace coppice
