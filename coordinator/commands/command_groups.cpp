#include "coordinator/commands/command_groups.hpp"

#include <CLI/CLI.hpp>
#include <array>
#include <string_view>
#include <utility>

namespace coppice {
namespace {

constexpr std::array<std::pair<std::string_view, std::string_view>, 24> kGroups = {{
    {"run", "Begin"},        {"learn", "Get a chain"}, {"import", "Get a chain"},  {"synth", "Get a chain"},
    {"evolve", "Evolve"},    {"refine", "Evolve"},     {"sweep", "Evolve"},        {"evaluate", "Evolve"},
    {"info", "Look"},        {"front", "Look"},        {"score", "Look"},          {"table", "Look"},
    {"draw", "Look"},        {"report", "Look"},       {"studio", "Look"},         {"verify", "Trust"},
    {"explain", "Trust"},    {"check", "Trust"},       {"edit", "Change"},         {"prune", "Change"},
    {"export", "Take away"}, {"backup", "Take away"},  {"workers", "Run a fleet"}, {"bench", "Run a fleet"},
}};

}  // namespace

void group_commands(CLI::App& app) {
  for (CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    command->group("More");
    for (const auto& [name, group] : kGroups) {
      if (name == command->get_name()) {
        command->group(std::string(group));
      }
    }
  }
}

}  // namespace coppice
