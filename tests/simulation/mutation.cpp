#include "coordinator/dispatch/mutation.hpp"

#include <algorithm>

namespace coppice {

Mutation active_mutation = Mutation::none;

bool set_mutation(const std::string& name) {
  const auto found = std::find(kMutationNames.begin(), kMutationNames.end(), name);
  if (found == kMutationNames.end()) {
    return false;
  }
  active_mutation = static_cast<Mutation>(found - kMutationNames.begin());
  return true;
}

}  // namespace coppice
