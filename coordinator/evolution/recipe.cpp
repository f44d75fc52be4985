#include "coordinator/evolution/recipe.hpp"

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <system_error>

#include "coordinator/evolution/config_text.hpp"
#include "coordinator/evolution/recipe_texts.hpp"

namespace coppice {

const std::vector<Recipe>& recipes() {
  static const std::vector<Recipe> all = {
      {"best", "readable trees that are safe and worth most in the simulator: the default", recipe_texts::kBest},
      {"thesis", "Table III of the thesis: one number decides", recipe_texts::kThesis},
      {"front", "faithful, safe and short trees, by a front of all measures", recipe_texts::kFront},
      {"coverage", "agreement in the most states, however rare", recipe_texts::kCoverage},
      {"return", "the highest return, whatever the policy does", recipe_texts::kReturn},
  };
  return all;
}

std::optional<Recipe> find_recipe(std::string_view name) {
  const auto found =
      std::find_if(recipes().begin(), recipes().end(), [&](const Recipe& recipe) { return recipe.name == name; });
  return found == recipes().end() ? std::nullopt : std::optional(*found);
}

std::string recipe_names() {
  std::string names;
  for (const Recipe& recipe : recipes()) {
    names += fmt::format("{}{}", names.empty() ? "" : ", ", recipe.name);
  }
  return names;
}

Result<void> load_recipe_or_file(const std::string& name, EvolveConfig& config) {
  if (const auto recipe = find_recipe(name)) {
    return read_config(recipe->toml, fmt::format("recipe {}", name), config);
  }
  std::error_code ignored;
  if (name.find_first_of("./") == std::string::npos && !std::filesystem::exists(name, ignored)) {
    return bad_input(
        fmt::format("--config {}: no such recipe or file: expected a file, or one of {}", name, recipe_names()));
  }
  return load_config(name, config);
}

}  // namespace coppice
