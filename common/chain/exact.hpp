// How often a walk through a chain is in each state, computed instead of sampled: no random numbers, no noise.
//
// X_0 is drawn from Chain::starts().
//
//   over_steps   v(s) = sum over i < t of P(X_i = s)                              sums to t
//   discounted   v(s) = (1 - gamma) x sum over i of gamma^i P(X_i = s)            sums to 1
//   long_run     v(s) = limit for t to infinity of over_steps / t                 sums to 1
//
// The first by t sparse products of the distribution with the transition matrix P of the acting tables, over the states
// that have mass; the others by one sparse LU of I - gamma P, transposed (for the long run gamma is 1 and the
// transitions into one state of each closed class are cut, so that the matrix is regular: Kemeny and Snell, Finite
// Markov Chains, 1960, chapters III and IV). A pair that was never tried leads to every state alike: a term of
// rank one, carried as such (Sherman and Morrison, 1950).
//
// Everything is summed in one order that depends on chain and tables only, so the same question gives the same bits, in
// any thread or process, on every x86-64 machine with the same build. Scratch memory of one thread.
#pragma once

#include <cstdint>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/chain/exact_lu.hpp"
#include "common/chain/exact_rows.hpp"

namespace coppice {

// Of discounted and long_run; beyond, fill-in decides whether there is any hope, and products do as well.
inline constexpr std::size_t kMaxSolvedStates = 65536;
inline constexpr double kMaxGamma = 0.999999;
// Probability that may be missing, or too much, in a solution.
inline constexpr double kSolveTolerance = 1e-6;

struct Occupancy {
  std::vector<std::uint32_t> states;  // distinct; all others have 0
  std::vector<double> visits;         // [states], expected
};

class ExactOccupancy {
 public:
  // `chain` outlives this.
  explicit ExactOccupancy(const Chain& chain);

  // As ReachedRows::set_probabilities(), for all calls that follow.
  void set_probabilities(std::span<const double> probabilities) { rows_.set_probabilities(probabilities); }

  // The results are valid until the next call.
  const Occupancy& over_steps(const ActingTables& acting, std::uint32_t steps);

  // Null: the factors would need more than kMaxFactorEntries, or rounding lost more than kSolveTolerance (which takes
  // exits of a probability near the last bit of a double). REQUIRES: chain.states() <= kMaxSolvedStates, and
  // 0 <= gamma <= kMaxGamma.
  const Occupancy* discounted(const ActingTables& acting, double gamma);
  const Occupancy* long_run(const ActingTables& acting);

 private:
  bool factorise(double gamma);
  void solve(std::vector<double>& x) const;
  bool cut(std::uint32_t number) const { return !classes_.empty() && classes_[number] == number; }
  std::vector<double> entered(const std::vector<double>& visits) const;

  const Chain& chain_;
  ReachedRows rows_;
  Occupancy result_;
  std::vector<double> now_;   // [states with mass]
  std::vector<double> next_;  // [states with mass]
  // Of the system being solved.
  std::vector<std::uint32_t> classes_;  // [reached], as closed_classes(); empty: none is cut
  SparseColumns columns_;
  SparseLu lu_;
  std::vector<double> spread_;  // [reached], the solution for a start that is uniform; empty: no uniform shares
  double gain_ = 1.0;           // 1 - the mass of spread_ that comes back to uniform shares
};

}  // namespace coppice
