// A configuration as text: read from TOML files, changed by assignments on the command line, and kept in a study as
// JSON; all three know the same keys (README.md lists them, thesis.toml has them all with their defaults).
#pragma once

#include <string>
#include <string_view>

#include "common/error.hpp"
#include "common/evolution/config.hpp"
#include "common/tree/vocabulary.hpp"

namespace coppice {

// Changes `config` by a TOML file: keys that the file leaves out keep their value. Errors name file, line and key (or
// line and column where it is not TOML), what was found and what was expected: an unknown key, a wrong type, a
// value out of range, a file that sets no key at all. On error `config` is unchanged.
Result<void> load_config(const std::string& path, EvolveConfig& config);

// The same for text that is already read, which may set nothing; `name` stands for the file in messages.
Result<void> read_config(std::string_view toml, const std::string& name, EvolveConfig& config);

// Changes one key: "ga.population=200", "rollout.acting=policy". Errors name the assignment as after "--set".
Result<void> apply_setting(std::string_view assignment, EvolveConfig& config);

// Changes one key to the value that a text spells: "ga.population", "200". Errors name the key.
Result<void> assign_text(std::string_view name, std::string_view value, EvolveConfig& config);

// check_search(), and that the pick rule can be read. Call it after the last change.
Result<void> check_config(const EvolveConfig& config, const Vocabulary& vocabulary);

// One line of JSON with every key; config_from_json(to_json(c)) gives exactly c.
std::string config_to_json(const EvolveConfig& config);
Result<EvolveConfig> config_from_json(std::string_view json);

}  // namespace coppice
