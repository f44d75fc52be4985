// The transitions of the states that the walk can reach when given action tables act, as compact rows: states are
// numbered in the order of discovery (breadth first from the states where episodes start), so what is summed over them
// is summed in one order, whatever the chain's numbering. What takes place is Chain::taken() of what acts. Two kinds of
// transition have no row in the chain: a state that is held stays where it is, and a pair that was never tried leads to
// every state alike; the latter is kept as one number for each row (its uniform share), never as a row of all states.
// Scratch memory of one thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/chain/chain.hpp"

namespace coppice {

// Who acts: in every step `others` with probability others_share, else `actions`. Entries are action indices; the
// number of actions stands for none.
struct ActingTables {
  std::span<const std::uint8_t> actions;  // [states]
  std::span<const std::uint8_t> others;   // [states]; empty when others_share is 0
  double others_share = 0.0;              // in [0, 1]
};

class ReachedRows {
 public:
  struct Transition {
    std::uint32_t to = 0;  // a number of this class, not of the chain
    double probability = 0.0;
  };

  // `chain` outlives this.
  explicit ReachedRows(const Chain& chain);

  // From now on transition i of the chain has this probability instead of count / tries; empty: count / tries again.
  // [transitions of the chain] REQUIRES: they outlive the calls of expand(); those of a row that is tried sum to 1.
  void set_probabilities(std::span<const double> probabilities);
  // Forgets everything; only the states where episodes start are discovered, numbered as in Chain::starts().
  // REQUIRES: the tables outlive the calls of expand().
  void begin(const ActingTables& acting);
  // Makes the rows of the states 0..rows - 1, which discovers their successors. REQUIRES: rows <= size().
  void expand(std::size_t rows);
  // Makes all rows of all states that can be reached.
  void expand_all();
  // Numbers all states of the chain: a uniform share leads everywhere.
  void discover_all();

  // The probability that an episode starts in each of the first states. [Chain::starts()]
  std::vector<double> start() const;

  std::size_t size() const { return states_.size(); }
  // The chain's states by number.
  const std::vector<std::uint32_t>& states() const { return states_; }
  // Distinct targets. REQUIRES (also below): the row was made.
  std::span<const Transition> row(std::size_t number) const {
    return std::span<const Transition>(transitions_).subspan(begin_[number], begin_[number + 1] - begin_[number]);
  }
  // Probability of going to a state drawn uniformly from all.
  double uniform(std::size_t number) const { return uniform_[number]; }
  std::size_t transitions() const { return transitions_.size(); }
  const Chain& chain() const { return chain_; }

 private:
  std::uint32_t number_of(std::uint32_t state);
  void add(std::uint32_t to, double probability);
  void add_action(std::uint32_t state, std::size_t action, double share);

  const Chain& chain_;
  std::span<const double> probabilities_;
  ActingTables acting_;
  std::vector<std::uint32_t> numbers_;  // [states of the chain], kUnknown where not discovered
  std::vector<std::uint32_t> states_;
  std::vector<std::size_t> begin_;  // [rows made + 1]
  std::vector<Transition> transitions_;
  std::vector<double> uniform_;  // [rows made]
};

}  // namespace coppice
