#include "common/chain/alias_bins.hpp"

#include <vector>

namespace coppice {

void fill_bins(std::span<const std::uint32_t> successors, std::span<const std::uint32_t> counts, std::uint32_t units,
               std::span<AliasBin> bins) {
  // One stack of bins with too little and one of bins with too much; kept, because rows are many and small.
  thread_local std::vector<std::uint64_t> scaled;  // n_i k
  thread_local std::vector<std::uint32_t> small;
  thread_local std::vector<std::uint32_t> large;
  const std::size_t count = successors.size();
  scaled.resize(count);
  small.clear();
  large.clear();
  for (std::size_t i = 0; i < count; ++i) {
    scaled[i] = std::uint64_t{counts[i]} * count;
    (scaled[i] < units ? small : large).push_back(static_cast<std::uint32_t>(i));
    bins[i] = {successors[i], successors[i], units};
  }
  while (!small.empty()) {
    const std::uint32_t lacking = small.back();
    small.pop_back();
    const std::uint32_t giving = large.back();  // exists: the bins' mean is exactly one full bin
    bins[lacking].alias = successors[giving];
    bins[lacking].threshold = static_cast<std::uint32_t>(scaled[lacking]);
    scaled[giving] -= units - scaled[lacking];
    if (scaled[giving] < units) {
      large.pop_back();
      small.push_back(giving);
    }
  }
}

}  // namespace coppice
