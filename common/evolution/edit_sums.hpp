// What an edit at one place of a tree would gain, summed over states: in all, and where a condition holds, for every
// condition of the vocabulary at once. A working part of edit_ranking.hpp. Scratch memory of one thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/evolution/edit_places.hpp"
#include "common/tree/node.hpp"

namespace coppice {

// The slot of every state's value among those of all features: sums are kept by slot.
struct ValueSlots {
  explicit ValueSlots(const Chain& chain);

  std::vector<std::uint32_t> slot;   // [states x features]
  std::vector<std::uint32_t> first;  // [features + 1]
};

// Which sum: the place fails, it succeeds without writing, or it writes action a and succeeds (kWrites + a).
inline constexpr std::size_t kFails = 0;
inline constexpr std::size_t kSucceeds = 1;
inline constexpr std::size_t kWrites = 2;

class EditSums {
 public:
  // gains: [states of the chain x (actions + 1)]. states: that matter. All outlive this.
  EditSums(const Chain& chain, const ValueSlots& slots, std::span<const double> gains,
           std::span<const std::uint32_t> states);

  // Takes up the place with these outcomes (EditPlaces::Outcome of m), where the tree now selects places.now(m). False:
  // it is reached nowhere.
  template <typename OutcomeOf>
  bool take_up(const EditPlaces& places, const OutcomeOf& outcome_of) {
    rows_.clear();
    states_here_.clear();
    bool any = false;
    for (std::size_t m = 0; m < states_.size(); ++m) {
      const EditPlaces::Outcome outcome = outcome_of(m);
      if (outcome.reached) {
        any = true;
        add_row(m, outcome, places.now(m));
      }
    }
    sum_up();
    return any;
  }

  // [sums], over the states in which the place is reached.
  const double* total() const { return total_.data(); }

  // Calls use(condition, [sums] where it holds) for every condition of the vocabulary.
  template <typename Use>
  void for_conditions(const Use& use) {
    const Vocabulary& vocabulary = chain_.vocabulary();
    for (std::size_t f = 0; f < vocabulary.features.size(); ++f) {
      const Feature& feature = vocabulary.features[f];
      up_to_.assign(sums_, 0.0);
      for (std::size_t v = 0; v < feature.values.size(); ++v) {
        const double* sums = by_value_.data() + (slots_.first[f] + v) * sums_;
        if (feature.admits_equal) {
          use(Node::condition(f, Op::equal, feature.values[v]), sums);
        }
        if (feature.admits_less_equal) {
          for (std::size_t k = 0; k < sums_; ++k) {
            up_to_[k] += sums[k];
          }
          if (v + 1 < feature.values.size()) {  // the last one always holds
            use(Node::condition(f, Op::less_equal, feature.values[v]), up_to_.data());
          }
        }
      }
    }
  }

  // This place, looked at only where a condition holds.
  EditSums where(const Node& condition) const;

 private:
  void add_row(std::size_t m, const EditPlaces::Outcome& outcome, std::uint8_t now);
  void sum_up();
  template <std::size_t kSums>
  void sum_up_sums();

  const Chain& chain_;
  const ValueSlots& slots_;
  std::span<const double> gains_;
  std::span<const std::uint32_t> states_;
  std::size_t stride_;
  std::size_t sums_;
  std::vector<std::uint32_t> states_here_;  // [rows], m: in which something is gained or lost
  std::vector<double> rows_;                // [rows x sums]
  std::vector<double> total_;               // [sums]
  std::vector<double> by_value_;            // [values of all features x sums]
  std::vector<double> up_to_;               // [sums]
};

}  // namespace coppice
