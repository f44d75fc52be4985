// Flags that many commands have, each declared once: --json, STUDY, --run, --seed. What belongs together and needs more
// than a line has a file of its own (study_tree, output_option, evaluator_option, simulate_option).
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace coppice {

inline constexpr std::uint32_t kMostThreads = 1024;
inline constexpr std::uint32_t kHighestDomain = 230;  // of DDS; above it the ports of RTPS run out

CLI::Option* add_json_flag(CLI::App& command, bool& json, const char* help = "Report as one JSON object");
CLI::Option* add_study_argument(CLI::App& command, std::string& study, const char* help = "The study file");
CLI::Option* add_run_option(CLI::App& command, std::optional<std::int64_t>& run, const char* help);
// With its default in the help.
CLI::Option* add_seed_option(CLI::App& command, std::uint64_t& seed, const char* help);
// Without one: the help says what happens.
CLI::Option* add_seed_option(CLI::App& command, std::optional<std::uint64_t>& seed, const char* help);

// To standard output, and out of its buffer: for what a person watches. A failure is found by main(), which looks at
// the stream at the end.
void print_now(const std::string& text);

}  // namespace coppice
