#include "coordinator/learning/windy_grid.hpp"

#include <numeric>

#include "common/check.hpp"

namespace coppice {

Vocabulary WindyGrid::vocabulary() {
  Vocabulary vocabulary;
  vocabulary.features = {{"x", std::vector<std::uint8_t>(kColumns), true, true},
                         {"y", std::vector<std::uint8_t>(kRows), true, true}};
  for (Feature& feature : vocabulary.features) {
    std::iota(feature.values.begin(), feature.values.end(), std::uint8_t{0});
  }
  vocabulary.actions = {"up", "down", "left", "right"};
  return vocabulary;
}

void WindyGrid::features_of(std::uint32_t code, std::span<std::uint8_t> features) {
  COPPICE_CHECK(code < kCodes && features.size() == 2);
  features[0] = static_cast<std::uint8_t>(code % kColumns);
  features[1] = static_cast<std::uint8_t>(code / kColumns);
}

std::uint32_t WindyGrid::code_of(std::span<const std::uint8_t> features) {
  COPPICE_CHECK(features.size() == 2 && features[0] < kColumns && features[1] < kRows);
  return static_cast<std::uint32_t>(features[1] * kColumns + features[0]);
}

}  // namespace coppice
