// What a policy is worth, and what changing it would be worth: the value of every state under given actions, how often
// a walk is in each state, and the advantage of every other action, all from one factorisation of I - gamma P.
//
//   V(s)    = r(s, pi(s)) + gamma x sum over s' of P(s' | s, pi(s)) V(s')            (I - gamma P) V = r
//   d(s)    = (1 - gamma) x sum over i of gamma^i P(X_i = s)                         (I - gamma P)^T d = (1 - gamma)
//   start A(s, a) = r(s, a) + gamma x sum over s' of P(s' | s, a) V(s') - V(s)
//
// They say what a change of policy from pi to pi' does (the performance difference lemma: Kakade and Langford,
// "Approximately optimal approximate reinforcement learning", ICML 2002, Lemma 6.1; Howard, Dynamic Programming and
// Markov Processes, 1960, for one state):
//
//   (1 - gamma) x (return of pi' - return of pi) = sum over s of d'(s) A(s, pi'(s))
//
// with d' of pi'; with d in its place the sum is the derivative of the return along the way from pi to pi', exact to
// first order in how much the occupancy changes, and known for every change at once.
//
// An action index equal to the number of actions stands for no action; what takes place is Chain::taken(). A pair that
// was never tried leads to every state alike, a term of rank one (Sherman and Morrison, 1950). Sums are made in one
// order: the same question gives the same bits. Scratch memory of one thread.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/chain/exact_lu.hpp"

namespace coppice {

class PolicyValue {
 public:
  // `chain` outlives this. REQUIRES: chain.states() <= kMaxSolvedStates.
  explicit PolicyValue(const Chain& chain);

  // Solves for V and d. rewards: [states x (actions + 1)]. False: the factors would be too large (kMaxFactorEntries),
  // or gamma is so near 1 that the matrix is singular to working precision. REQUIRES: 0 <= gamma <= kMaxGamma,
  // actions.size() == chain.states(), each at most the number of actions.
  [[nodiscard]] bool solve(std::span<const std::uint8_t> actions, std::span<const double> rewards, double gamma);

  // What solve() would make expected_return(), by less: only the states that the walk can come to are solved. alike:
  // was solved for actions much the same (another object), whose order of elimination then serves here; may be null.
  // Nothing: as solve() false. REQUIRES: as solve(). Leaves values() and occupancy() undefined.
  [[nodiscard]] std::optional<double> return_of(std::span<const std::uint8_t> actions, std::span<const double> rewards,
                                                double gamma, const PolicyValue* alike);

  // Of the last solve(), which was true.
  std::span<const double> values() const { return values_; }        // [states], V
  std::span<const double> occupancy() const { return occupancy_; }  // [states], d; sums to 1
  // The discounted return from where episodes start.
  double expected_return() const { return return_; }
  // A(s, a). [states x (actions + 1)] `rewards` as given to solve().
  void advantages(std::span<const double> rewards, std::vector<double>& result) const;

 private:
  void fill_columns(std::span<const std::uint8_t> actions);
  bool find_walked(std::span<const std::uint8_t> actions);
  void fill_walked_columns(std::span<const std::uint8_t> actions);
  double next_value(std::size_t state, std::size_t chosen) const;

  const Chain& chain_;
  double gamma_ = 0.0;
  SparseColumns columns_;        // column s holds the transitions from s: I - gamma P, transposed
  std::vector<double> uniform_;  // [states], probability of going to a state drawn uniformly
  SparseLu lu_;
  std::vector<double> values_;
  std::vector<double> occupancy_;
  double mean_value_ = 0.0;  // of V over all states
  double return_ = 0.0;
  bool whole_ = false;                 // lu_ is of all states
  std::vector<std::uint32_t> walked_;  // states that the walk comes to, in order
  std::vector<std::int32_t> place_;    // [states], in walked_; -1: not there
};

}  // namespace coppice
