// What a user may have meant by a command or flag that does not exist.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace CLI {
class App;
}

namespace coppice {

// The candidates that differ from `word` by the fewest letters (added, left out, changed, or two neighbours swapped:
// Damerau 1964, each letter moved at most once), if that is at most a third of its letters, or one that begins with it.
// In the order given; empty: none is near.
std::vector<std::string> nearest(std::string_view word, const std::vector<std::string>& candidates);

// " (did you mean --workers?)", or nothing: for a word that `command` takes neither as subcommand nor as flag.
std::string did_you_mean(std::string_view word, const CLI::App& command);

}  // namespace coppice
