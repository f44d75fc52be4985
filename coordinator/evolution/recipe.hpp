// Configurations that come with the program, by name: the files NAME.toml of this folder, compiled in, so that
// `--config return` works wherever the program is installed. Pure functions.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/error.hpp"
#include "common/evolution/config.hpp"

namespace coppice {

struct Recipe {
  std::string_view name;     // "return"
  std::string_view purpose;  // one line, for help
  std::string_view toml;
};

const std::vector<Recipe>& recipes();
std::optional<Recipe> find_recipe(std::string_view name);
// "best, thesis, ...", for messages and help.
std::string recipe_names();

// Changes `config` by the recipe of that name or, where there is none, by the file (load_config). Errors: as
// load_config(); where neither exists, the recipes that do.
Result<void> load_recipe_or_file(const std::string& name, EvolveConfig& config);

}  // namespace coppice
