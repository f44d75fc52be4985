#include "coordinator/study/checkpoint_text.hpp"

#include <charconv>
#include <cmath>
#include <fmt/format.h>
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

}  // namespace coppice
