#include "common/evolution/champion.hpp"

#include <algorithm>

#include "common/check.hpp"

namespace coppice {

void enter(const Champion& champion, HallOfFame& hall) {
  const auto known =
      std::find_if(hall.begin(), hall.end(), [&](const Champion& other) { return other.tree == champion.tree; });
  if (known == hall.end()) {
    hall.push_back(champion);
  } else if (champion.fitness > known->fitness) {
    known->fitness = champion.fitness;
    known->agreement = champion.agreement;
  }
}

const Champion& best_on_record(const HallOfFame& hall) {
  COPPICE_CHECK(!hall.empty());
  return *std::min_element(hall.begin(), hall.end(), [](const Champion& a, const Champion& b) {
    return a.fitness != b.fitness ? a.fitness > b.fitness : a.tree.size() < b.tree.size();
  });
}

}  // namespace coppice
