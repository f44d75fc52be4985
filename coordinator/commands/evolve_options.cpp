#include "coordinator/commands/evolve_options.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "common/chain/exact.hpp"
#include "coordinator/commands/whole_number.hpp"
#include "coordinator/evolution/config_text.hpp"
#include "coordinator/evolution/recipe.hpp"

namespace coppice {
namespace {

constexpr double kNoGamma = -1.0;  // no configuration can have it

// Where a configuration comes from that is wrong as a whole.
std::string given_by(const EvolveOptions& options) {
  if (options.settings.empty()) {
    return options.config_file;
  }
  const std::string settings = fmt::format("--set {}", fmt::join(options.settings, " --set "));
  return options.config_file.empty() ? settings : fmt::format("{} with {}", options.config_file, settings);
}

}  // namespace

void add_evolve_options(CLI::App& command, EvolveOptions& options) {
  command
      .add_option("--config", options.config_file,
                  fmt::format("A recipe ({}) or a file, whose missing keys are as in the thesis (default: best)",
                              recipe_names()))
      ->type_name("RECIPE|FILE.toml");
  command.add_option("--set", options.settings, "Change one key, after --config; may be repeated")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  CLI::Option* prefer =
      command
          .add_option("--prefer", options.prefer,
                      "The answer of a front: by what trees are worth in the simulator, or on the chain without one")
          ->type_name("balance|return|agreement|coverage|size");
  command.add_option("--pick", options.pick, "The answer of a front: by a rule, as 'best return with coverage>=0.8'")
      ->type_name("RULE")
      ->excludes(prefer);
  command
      .add_option("--lines-every", options.lines_every,
                  "Generations between progress lines when standard error is no terminal (default: a line every 5 s)")
      ->type_name("N")
      ->check(whole_number());
}

Result<EvolveConfig> evolve_config(const EvolveOptions& options, std::optional<std::uint64_t> seed,
                                   const EvolveSubject& subject) {
  EvolveConfig config;
  const double unset = config.rollout.gamma;
  config.rollout.gamma = kNoGamma;
  const std::string recipe = !options.config_file.empty()             ? options.config_file
                             : subject.discount && !subject.simulated ? "return"
                                                                      : "best";
  if (options.config_file.empty() && subject.base != nullptr) {
    config = *subject.base;
  } else if (const Result<void> loaded = load_recipe_or_file(recipe, config); !loaded) {
    return tl::unexpected(loaded.error());
  }
  for (const std::string& setting : options.settings) {
    if (const Result<void> applied = apply_setting(setting, config); !applied) {
      return tl::unexpected(applied.error());
    }
  }
  if (config.rollout.gamma == kNoGamma) {
    config.rollout.gamma = subject.discount && *subject.discount <= kMaxGamma ? *subject.discount : unset;
  }
  config.seed = seed.value_or(config.seed);
  if (!options.pick.empty()) {
    config.front.pick = options.pick;
    config.front.prefer = Prefer::pick;
  }
  if (!options.prefer.empty()) {
    if (const Result<void> applied = assign_text("front.prefer", options.prefer, config); !applied) {
      return in_context("--prefer", applied.error());
    }
  }
  if (const Result<void> checked = check_config(config, subject.vocabulary); !checked) {
    const std::string place = given_by(options);
    return place.empty() ? tl::unexpected(checked.error()) : in_context(place, checked.error());
  }
  return config;
}

}  // namespace coppice
