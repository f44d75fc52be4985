#include "common/evolution/migration.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "common/chain/random.hpp"
#include "common/check.hpp"

namespace coppice {

DemeShare share_of(const GaConfig& ga, std::uint32_t deme) {
  COPPICE_CHECK(deme < ga.demes);
  const std::uint32_t each = ga.population / ga.demes;
  const std::uint32_t larger = ga.population % ga.demes;
  return {each * deme + std::min(deme, larger), each + (deme < larger ? 1 : 0)};
}

std::uint32_t epoch_length(const GaConfig& ga) { return ga.demes == 1 || ga.epoch == 0 ? ga.generations : ga.epoch; }

std::uint32_t epochs_of(const GaConfig& ga) {
  const std::uint32_t length = epoch_length(ga);
  return ga.generations / length + (ga.generations % length == 0 ? 0 : 1);
}

std::uint32_t epoch_end(const GaConfig& ga, std::uint32_t epoch) {
  COPPICE_CHECK(epoch < epochs_of(ga));
  return epoch + 1 == epochs_of(ga) ? ga.generations : (epoch + 1) * epoch_length(ga);
}

std::vector<std::uint32_t> senders_of(const EvolveConfig& config, std::uint32_t epoch) {
  const std::uint32_t demes = config.ga.demes;
  if (epoch == 0 || demes == 1 || config.ga.migrants == 0) {
    return {};
  }
  std::vector<std::uint32_t> ring(demes);
  std::iota(ring.begin(), ring.end(), 0U);
  if (config.ga.migration == Migration::random) {
    Stream stream(config.seed, Purpose::meeting, epoch, 0);
    for (std::uint32_t left = demes; left > 1; --left) {
      std::swap(ring[left - 1], ring[stream.below(left)]);
    }
  }
  std::vector<std::uint32_t> senders(demes);
  for (std::uint32_t i = 0; i < demes; ++i) {
    senders[ring[(i + 1) % demes]] = ring[i];
  }
  return senders;
}

}  // namespace coppice
