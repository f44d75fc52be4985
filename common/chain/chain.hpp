// The Markov chain counted while a policy was learned: for every (state, action) the successors seen, how often,
// and the reward they gave; with each state's features, Q-values, policy action and visits (thesis V and VI-E.2).
// A Chain is immutable and was checked when it was made, so the evaluation kernel indexes it without tests.
// Safe to share between threads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/error.hpp"
#include "common/tree/vocabulary.hpp"

namespace coppice {

inline constexpr std::size_t kMaxStates = std::size_t{1} << 28U;
inline constexpr std::size_t kMaxTransitions = std::size_t{1} << 31U;

// The chain's content, as it is filled in by whoever makes one. Rows are (state, action) pairs in state-major
// order: row = state * actions + action.
struct ChainParts {
  Vocabulary vocabulary;
  std::vector<std::uint8_t> features;    // [states x features]
  std::vector<std::uint64_t> row_begin;  // [states * actions + 1], into successor and count
  std::vector<std::uint32_t> successor;  // [transitions], ascending and unique in a row
  std::vector<std::uint32_t> count;      // [transitions], >= 1; a row's sum stays below 2^32
  std::vector<double> reward_sum;        // [states x actions], sum over all tries; finite; 0 where never tried
  std::vector<double> q;                 // [states x actions], finite
  std::vector<ActionId> policy;          // [states], the action that the learned policy takes
  std::vector<std::uint64_t> visits;     // [states], how often the agent was in the state while it learned
  std::uint32_t initial_state = 0;
  bool operator==(const ChainParts&) const = default;
};

class Chain {
 public:
  // Errors name the state or row and what was expected: sizes that disagree, indices out of range, a zero count,
  // a row whose total reaches 2^32, rewards or Q-values that are not finite, a feature value that the vocabulary does
  // not list, two states with the same features.
  static Result<Chain> make(ChainParts parts);

  const ChainParts& parts() const { return parts_; }
  const Vocabulary& vocabulary() const { return parts_.vocabulary; }
  std::size_t states() const { return parts_.policy.size(); }
  std::size_t actions() const { return parts_.vocabulary.actions.size(); }
  std::size_t transitions() const { return parts_.successor.size(); }
  std::uint32_t initial_state() const { return parts_.initial_state; }
  ActionId policy(std::size_t state) const { return parts_.policy[state]; }
  std::size_t row(std::size_t state, ActionId action) const { return state * actions() + index_of(action); }

  // [features] of one state.
  std::span<const std::uint8_t> features_of(std::size_t state) const;
  // The successors of a row and their counts; both empty when the pair was never tried.
  std::span<const std::uint32_t> successors(std::size_t row) const;
  std::span<const std::uint32_t> counts(std::size_t row) const;
  // N(s, a): how often the pair was tried.
  std::uint64_t tries(std::size_t row) const { return tries_[row]; }
  // Mean reward of a pair; 0 when never tried.
  double mean_reward(std::size_t row) const;

 private:
  explicit Chain(ChainParts parts) : parts_(std::move(parts)) {}

  ChainParts parts_;
  std::vector<std::uint64_t> tries_;  // [states x actions]
};

// The greedy policy on q [states x actions]: the action of the highest value, ties to the lowest index.
std::vector<ActionId> greedy_policy(std::span<const double> q, std::size_t actions);

}  // namespace coppice
