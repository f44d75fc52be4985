// Which of a model's rewards counts: a name, or several with signs. A plain value.
#pragma once

#include <string>
#include <vector>

#include "common/error.hpp"

namespace coppice {

struct RewardWeights {
  std::vector<double> weight;  // [reward models], +1, -1 or 0
};

// `wanted` as in read_drn(). Errors: several models and none wanted, or one that is not there; both list the names.
Result<RewardWeights> choose_reward(const std::vector<std::string>& names, const std::string& wanted);

}  // namespace coppice
