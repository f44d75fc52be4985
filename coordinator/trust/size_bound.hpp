// The most that any tree of so many conditions can earn, by the discount that the problem was solved with: how far from
// the best of its size a tree is, and proven to be one of the best where the bound is what it earns.
//
// A tree of n conditions, whatever holds them together, does the same in all states in which the same of these hold. So
// its return is at most that of the best policy that takes one action (or none) in each of the up to 2^n cells that
// some n conditions make. For every set of n conditions that tell the chain's states apart in another way, this is
// searched by branch and bound (Land and Doig, Econometrica 28, 1960) over the cells: cells with their action fixed,
// the others free in every state, which is a Markov decision process whose optimum (policy iteration: Howard 1960) is
// an upper bound; branched on is the cell in which that optimum disagrees with itself most, by occupancy; what promises
// no more than the best known is left. Trees earn the bound or less: n conditions may make cells that no tree of n
// conditions can tell apart.
//
// A pure function of its arguments; the effort is counted in solutions, not in time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>

#include "common/chain/chain.hpp"
#include "common/error.hpp"
#include "common/tree/tree.hpp"

namespace coppice {

struct SizeBound {
  double gamma = 0.0;
  double tree = 0.0;        // discounted return from where episodes start
  double policy = 0.0;      // the same of the policy
  double any_policy = 0.0;  // of the best policy that there is
  std::size_t conditions = 0;
  double sets = 0.0;         // of so many conditions
  std::uint64_t solved = 0;  // Markov decision processes
  bool closed = false;       // else `most` is any_policy
  double most = 0.0;         // no tree of so many conditions earns more

  // To rounding.
  bool tree_is_best() const;
};

// Searches until it is closed, or `effort` processes were solved; not at all where there are more sets than that.
// `go_on` is asked now and then, false ends it with an error (interrupted); may be empty. Errors: the chain is too
// large to be solved. REQUIRES: check_tree(tree, chain.vocabulary()), 0 <= gamma <= kMaxGamma.
Result<SizeBound> bound_of_size(const Chain& chain, const Tree& tree, double gamma, std::uint64_t effort,
                                const std::function<bool()>& go_on);

}  // namespace coppice
