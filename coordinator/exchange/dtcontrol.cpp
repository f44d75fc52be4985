#include "coordinator/exchange/dtcontrol.hpp"

#include <fmt/format.h>

namespace coppice {

void write_dtcontrol(const Chain& chain, std::ostream& out) {
  const std::vector<Feature>& features = chain.vocabulary().features;
  out << "#NON-PERMISSIVE\n#BEGIN " << features.size() << " 1\n";
  for (std::size_t state = 0; state < chain.states(); ++state) {
    if (chain.is_terminal(state)) {
      continue;
    }
    for (std::size_t f = 0; f < features.size(); ++f) {
      const std::uint8_t value = chain.features_of(state)[f];
      out << (features[f].scale == Scale::bins ? fmt::format("{}", value) : features[f].number_text(value)) << ',';
    }
    out << index_of(chain.policy(state)) << '\n';
  }
}

}  // namespace coppice
