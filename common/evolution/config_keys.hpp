// The keys of an EvolveConfig, once, for every form that a configuration comes in: each names a field, its type, its
// range and what it is for. TOML files, assignments and JSON differ only in how they spell a value.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "common/error.hpp"
#include "common/evolution/config.hpp"

namespace coppice {

// Something that no key takes (a date, a list), described for the message.
struct OtherValue {
  std::string description;
};
using ConfigValue = std::variant<std::int64_t, std::uint64_t, double, std::string, OtherValue>;

struct ConfigKey {
  std::string section;  // "ga"; empty: top level
  std::string name;
  std::variant<std::uint32_t*, std::uint64_t*, std::int32_t*, double*, Acting*, Method*, Start*, Form*, Search*,
               Simplification*, Seeding*, Schedule*, Prefer*, Migration*, std::string*, std::vector<Measure>*>
      field;
  double low = 0.0;  // range of a number, both included; of std::uint64_t: all
  double high = 0.0;
  std::string_view help = {};  // one sentence, for `coppice help keys` and the comments of thesis.toml

  std::string full_name() const { return section.empty() ? name : section + "." + name; }
};

// The keys bound to the fields of `config`, which must outlive them. Rules are not among them.
std::vector<ConfigKey> keys_of(EvolveConfig& config);
// right and wrong of a rule.
std::vector<ConfigKey> keys_of(RuleConfig& rule);

// Errors name the key, the value found and what was expected.
Result<void> assign(const ConfigKey& key, const ConfigValue& value);

// What the field holds.
ConfigValue value_of(const ConfigKey& key);

inline constexpr std::string_view kRuleKey = "rule";     // [[fitness.rule]]
inline constexpr std::string_view kAnyOfKey = "any_of";  // of a rule

// The key, or an error that lists those of its section, or the sections. REQUIRES: keys come from keys_of().
Result<const ConfigKey*> find_key(const std::vector<ConfigKey>& keys, std::string_view section, std::string_view name);

// Whether some key is in this section.
bool is_section(const std::vector<ConfigKey>& keys, std::string_view section);

}  // namespace coppice
