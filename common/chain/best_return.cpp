#include "common/chain/best_return.hpp"

#include <algorithm>
#include <numeric>
#include <vector>

#include "common/check.hpp"

namespace coppice {
namespace {

// Backward induction; choose(state, worth): the value of the state, given what each choice is worth, no action last.
template <typename Choose>
double induced(const Chain& chain, std::uint32_t steps, const Choose& choose) {
  const std::size_t states = chain.states();
  const std::size_t actions = chain.actions();
  std::vector<double> after(states, 0.0);
  std::vector<double> before(states);
  std::vector<double> worth(actions + 1);
  for (std::uint32_t step = 0; step < steps; ++step) {
    const double mean = std::accumulate(after.begin(), after.end(), 0.0) / static_cast<double>(states);
    for (std::size_t s = 0; s < states; ++s) {
      for (std::size_t chosen = 0; chosen <= actions; ++chosen) {
        const std::size_t taken = chain.taken(s, chosen);
        if (taken == actions) {
          worth[chosen] = after[s];
          continue;
        }
        const std::size_t row = s * actions + taken;
        double sum = 0.0;
        for (std::size_t i = 0; i < chain.successors(row).size(); ++i) {
          sum += static_cast<double>(chain.counts(row)[i]) * after[chain.successors(row)[i]];
        }
        const std::uint64_t tries = chain.tries(row);
        worth[chosen] = tries == 0 ? mean : chain.mean_reward(row) + sum / static_cast<double>(tries);
      }
      before[s] = choose(s, worth);
    }
    before.swap(after);
  }
  double sum = 0.0;
  for (const StartShare& start : chain.starts()) {
    sum += static_cast<double>(start.count) / static_cast<double>(chain.starts_total()) * after[start.state];
  }
  return sum;
}

}  // namespace

double best_return(const Chain& chain, std::uint32_t steps) {
  return induced(chain, steps, [](std::size_t, const std::vector<double>& worth) {
    return *std::max_element(worth.begin(), worth.end());
  });
}

double return_of(const Chain& chain, std::span<const std::uint8_t> actions, std::uint32_t steps) {
  COPPICE_CHECK(actions.size() == chain.states());
  return induced(chain, steps, [&](std::size_t s, const std::vector<double>& worth) { return worth[actions[s]]; });
}

}  // namespace coppice
