#include "common/evolution/deme_search.hpp"

#include "common/evolution/front_search.hpp"
#include "common/evolution/scalar_search.hpp"

namespace coppice {

Result<std::unique_ptr<DemeSearch>> DemeSearch::make(const Chain& chain, const EvolveConfig& config) {
  return config.ga.search == Search::front ? make_front_search(chain, config) : make_scalar_search(chain, config);
}

}  // namespace coppice
