// What else a chain's transition probabilities could be, given that they were counted: draws from their posterior, to
// carry the uncertainty of the counts into whatever is computed from them.
//
// The row of a (state, action) pair with counts n_1..n_k is drawn from the Dirichlet distribution with parameters
// n_1..n_k: the posterior under Haldane's prior, also known as the Bayesian bootstrap (Rubin, "The Bayesian bootstrap",
// Annals of Statistics 1981). A successor that was never seen stays impossible in a draw: missing_mass() says what that
// leaves out. Gamma variates by Marsaglia and Tsang, "A simple method for generating gamma variables", ACM TOMS 2000.
//
// Owns its generator; one thread. The same seed gives the same draws.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/chain/random.hpp"

namespace coppice {

class CountPosterior {
 public:
  // `chain` outlives this.
  CountPosterior(const Chain& chain, std::uint64_t seed) : chain_(chain), random_(seed) {}

  // Overwrites the probabilities of these rows' transitions with a draw. probabilities: [transitions of the chain].
  // REQUIRES: every row was tried.
  void draw(std::span<const std::size_t> rows, std::span<double> probabilities);

  // A draw from Gamma(shape, 1). REQUIRES: shape >= 1.
  double gamma(double shape);

 private:
  double uniform();  // in (0, 1)
  double normal();

  const Chain& chain_;
  Xoshiro256 random_;
};

// Good and Turing's estimate of the probability that the next try of a row leads to a successor never seen there: the
// share of its tries that were the only one of their kind (Good, "The population frequencies of species and the
// estimation of population parameters", Biometrika 1953). REQUIRES: the row was tried.
double missing_mass(const Chain& chain, std::size_t row);

}  // namespace coppice
