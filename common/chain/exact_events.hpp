// When a walk through a chain first meets an event, computed instead of sampled: the probability that it does within t
// steps and ever, and the expected number of steps until it does.
//
// An event happens, with some probability, when the acting table's action is taken in a state. A walk ends with the
// event, or when it takes an action that was never tried there: what would follow is not known. So a probability here
// is that of the event before the walk leaves the learned model; with that of leaving added it is an upper bound.
//
// Within t steps: t sparse products. Ever: with B the transitions between states from which the event can be reached
// (all others never lead to it and are left out, which makes I - B regular), and c the event's probability in each
// state,
//
//   x = (I - B)^-T e_start     expected visits before the walk ends       P(event) = sum of x c
//   y = (I - B)^-T x           visits at step i, weighted with i + 1      E[steps; event] = sum of y c
//
// (Kemeny and Snell, Finite Markov Chains, 1960, chapter III: the fundamental matrix of an absorbing chain), by one
// sparse LU (exact_lu.hpp). Scratch memory of one thread.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/chain/exact_lu.hpp"
#include "common/chain/exact_rows.hpp"

namespace coppice {

struct FirstEvent {
  double probability = 0.0;  // that it ever happens; exactly 1 where the walk cannot but meet it
  double steps = 0.0;        // expected, up to and with the event, of the walks that meet it; 0 when none does
};

class ExactEvents {
 public:
  // `chain` outlives this.
  explicit ExactEvents(const Chain& chain) : rows_(chain) {}

  // Whose walk the calls below are about. `probabilities` as ReachedRows::set_probabilities(). REQUIRES: both outlive
  // them, acting.others_share == 0.
  void begin(const ActingTables& acting, std::span<const double> probabilities = {});

  // The states that the walk can reach before it ends for good.
  const std::vector<std::uint32_t>& states() const { return rows_.states(); }

  // chance: [states of the chain] that acting there is the event.
  double within(std::span<const double> chance, std::uint32_t steps);

  // Nothing: the factors would need more than kMaxFactorEntries, or rounding lost more than kSolveTolerance.
  // REQUIRES: chain.states() <= kMaxSolvedStates.
  std::optional<FirstEvent> ever(std::span<const double> chance);

 private:
  std::vector<bool> before_event(const std::vector<double>& chance) const;
  std::vector<bool> leading_to_event(const std::vector<double>& chance, const std::vector<bool>& alive) const;

  ReachedRows rows_;
  std::vector<double> now_;
  std::vector<double> next_;
  SparseColumns columns_;
  SparseLu lu_;
};

}  // namespace coppice
