#include "coordinator/study/checkpoint_text.hpp"

#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <iterator>
#include <optional>
#include <system_error>

#include "common/check.hpp"
#include "common/tree/text.hpp"

namespace coppice {

std::string population_text(const FitTrees& population, const Vocabulary& vocabulary) {
  COPPICE_CHECK(population.trees.size() == population.fitness.size());
  std::string text;
  for (std::size_t slot = 0; slot < population.trees.size(); ++slot) {
    text += fmt::format("{}\t{}\n", population.fitness[slot], to_text(population.trees[slot], vocabulary));
  }
  return text;
}

namespace {

// A finite number that is the whole field; ranking needs one that is not NaN.
std::optional<double> fitness_from(std::string_view field) {
  double fitness = 0.0;
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), fitness);
  if (error != std::errc() || end != field.data() + field.size() || !std::isfinite(fitness)) {
    return std::nullopt;
  }
  return fitness;
}

}  // namespace

Result<FitTrees> population_from_text(std::string_view text, const Vocabulary& vocabulary) {
  FitTrees population;
  for (std::size_t line_number = 1; !text.empty(); ++line_number) {
    const std::size_t end = text.find('\n');
    const std::string_view line = text.substr(0, end);
    const std::size_t tab = line.find('\t');
    const auto fitness = tab == std::string_view::npos ? std::nullopt : fitness_from(line.substr(0, tab));
    if (end == std::string_view::npos || !fitness) {
      return bad_input(fmt::format("line {}: expected a fitness, a tab and a tree", line_number));
    }
    auto tree = parse_tree(line.substr(tab + 1), vocabulary);
    if (!tree) {
      return in_context(fmt::format("line {}", line_number), tree.error());
    }
    population.trees.push_back(std::move(*tree));
    population.fitness.push_back(*fitness);
    text.remove_prefix(end + 1);
  }
  return population;
}

std::string archives_text(const KeptTrees& archives, const Vocabulary& vocabulary) {
  std::string text;
  std::size_t slot = 0;
  const auto write = [&](std::size_t end) {
    for (; slot < end; ++slot) {
      text += fmt::format("0\t{}\n", to_text(archives.trees[slot], vocabulary));
    }
  };
  for (const std::size_t kept : archives.kept) {
    COPPICE_CHECK(kept <= archives.trees.size() - slot);
    write(slot + kept);
    text += '\n';
  }
  COPPICE_CHECK(archives.kept.empty() || slot == archives.trees.size());
  write(archives.trees.size());
  return text;
}

Result<KeptTrees> archives_from_text(std::string_view text, const Vocabulary& vocabulary) {
  KeptTrees archives;
  while (!text.empty()) {
    const std::size_t empty_line = text.front() == '\n' ? 0 : text.find("\n\n");
    const bool closed = empty_line != std::string_view::npos;
    const std::size_t end = !closed ? text.size() : empty_line == 0 ? 0 : empty_line + 1;
    auto archive = population_from_text(text.substr(0, end), vocabulary);
    if (!archive) {
      return archives.kept.empty() ? tl::unexpected(archive.error())
                                   : in_context(fmt::format("deme {}", archives.kept.size()), archive.error());
    }
    if (!closed && !archives.kept.empty()) {
      return bad_input(fmt::format("deme {}: expected an empty line at its end", archives.kept.size()));
    }
    if (closed) {
      archives.kept.push_back(archive->trees.size());
    }
    std::move(archive->trees.begin(), archive->trees.end(), std::back_inserter(archives.trees));
    text.remove_prefix(closed ? end + 1 : end);
  }
  return archives;
}

}  // namespace coppice
