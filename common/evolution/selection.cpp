#include "common/evolution/selection.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/check.hpp"

namespace coppice {

std::vector<std::size_t> ranking(std::span<const Tree> population, std::span<const double> fitness) {
  COPPICE_CHECK(population.size() == fitness.size());
  std::vector<std::size_t> slots(population.size());
  std::iota(slots.begin(), slots.end(), std::size_t{0});
  std::stable_sort(slots.begin(), slots.end(), [&](std::size_t a, std::size_t b) {
    return fitness[a] != fitness[b] ? fitness[a] > fitness[b] : population[a].size() < population[b].size();
  });
  return slots;
}

std::size_t tournament_size(double share, std::size_t population) {
  const auto rounded = static_cast<std::size_t>(std::llround(share * static_cast<double>(population)));
  return std::clamp(rounded, std::size_t{1}, population);
}

std::size_t tournament(Stream& stream, std::span<const double> fitness, std::size_t size) {
  COPPICE_CHECK(!fitness.empty() && size >= 1);
  std::size_t winner = stream.below(fitness.size());
  for (std::size_t i = 1; i < size; ++i) {
    const std::size_t rival = stream.below(fitness.size());
    if (fitness[rival] > fitness[winner]) {
      winner = rival;
    }
  }
  return winner;
}

}  // namespace coppice
