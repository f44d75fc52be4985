#include "coordinator/commands/did_you_mean.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <iterator>

namespace coppice {
namespace {

constexpr std::size_t kMostSuggestions = 3;
constexpr std::size_t kLongestWord = 64;  // longer ones are no slip of the finger

// Optimal string alignment: three rows of the table are enough.
std::size_t distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before_last(b.size() + 1);
  std::vector<std::size_t> last(b.size() + 1);
  std::vector<std::size_t> now(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) {
    last[j] = j;
  }
  for (std::size_t i = 1; i <= a.size(); ++i) {
    now[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t change = last[j - 1] + (a[i - 1] == b[j - 1] ? 0U : 1U);
      now[j] = std::min({last[j] + 1, now[j - 1] + 1, change});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        now[j] = std::min(now[j], before_last[j - 2] + 1);
      }
    }
    before_last.swap(last);
    last.swap(now);
  }
  return last[b.size()];
}

}  // namespace

std::vector<std::string> nearest(std::string_view word, const std::vector<std::string>& candidates) {
  std::vector<std::string> found;
  if (word.empty() || word.size() > kLongestWord) {
    return found;
  }
  const std::size_t dashes = std::min(word.find_first_not_of('-'), word.size());  // those are no letters
  const std::size_t most = std::max<std::size_t>((word.size() - dashes) / 3, 1);
  std::size_t best = most + 1;
  for (const std::string& candidate : candidates) {
    const std::size_t differs = distance(word, candidate);
    if (differs < best) {
      best = differs;
      found.clear();
    }
    if (differs == best && differs <= most) {
      found.push_back(candidate);
    }
  }
  if (found.empty() && word.size() > dashes + 1) {
    std::copy_if(candidates.begin(), candidates.end(), std::back_inserter(found),
                 [&](const std::string& candidate) { return candidate.starts_with(word); });
  }
  if (found.size() > kMostSuggestions) {
    found.resize(kMostSuggestions);
  }
  return found;
}

std::string did_you_mean(std::string_view word, const CLI::App& command) {
  std::vector<std::string> candidates;
  if (word.starts_with('-')) {
    word = word.substr(0, word.find('='));
    for (const CLI::Option* option : command.get_options()) {
      for (const std::string& name : option->get_lnames()) {
        candidates.push_back("--" + name);
      }
    }
  } else {
    for (const CLI::App* subcommand : command.get_subcommands([](const CLI::App*) { return true; })) {
      candidates.push_back(subcommand->get_name());
    }
  }
  const std::vector<std::string> found = nearest(word, candidates);
  return found.empty() ? "" : fmt::format(" (did you mean {}?)", fmt::join(found, " or "));
}

}  // namespace coppice
