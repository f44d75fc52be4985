// The Markov chain counted while a policy was learned, or made of a model's probabilities: for every (state, action)
// the successors, how often, and the reward they gave; with each state's features, Q-values, policy action and visits
// (thesis V and VI-E.2); where episodes start, which states end them, which actions a state lacks, and what happens
// when a tree chooses none. Everything that an evaluation needs is here, so that a chain alone can be sent to a worker;
// what only people need (labels, units) is in a study's problem.
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

// What happens in a step for which a tree chooses no action, or one that is forbidden in the state.
struct NoAction {
  enum class Kind : std::uint8_t {
    hold = 0,   // the state is held and nothing earned (thesis III-B)
    worst = 1,  // of the actions tried in the state the one of the lowest Q-value, ties to the lowest index
    named = 2,  // `action`; where it is forbidden the worst
  };
  Kind kind = Kind::hold;
  ActionId action{};  // named only, else 0
  bool operator==(const NoAction&) const = default;
};

struct StartShare {
  std::uint32_t state = 0;
  std::uint32_t count = 0;  // >= 1: the state's share of the sum of all
  bool operator==(const StartShare&) const = default;
};

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
  std::uint32_t initial_state = 0;       // with several starts, the first of them
  // What follows is empty, or as it is here, in a chain that has no need of it.
  std::vector<StartShare> starts = {};  // two or more, by ascending state; the sum of counts below 2^32
  NoAction no_action = {};
  bool look_alikes = false;  // states may have the same features: a tree cannot tell them apart, the chain does
  // States that end an episode, ascending: nothing is decided there, so whatever is chosen counts as the policy's
  // choice and scores as it. What follows is in their rows: themselves (absorbing, no reward), or the starts (the next
  // episode). All rows of such a state are alike.
  std::vector<std::uint32_t> terminals = {};
  // [states x actions], 1: the state lacks the action; its row is empty, reward 0. Never the policy's action, but in a
  // state that has no action at all.
  std::vector<std::uint8_t> forbidden = {};
  // [states x actions], how many of a row's tries were collisions; empty: nobody said, a threshold on the mean reward
  // has to.
  std::vector<std::uint32_t> collisions = {};
  bool operator==(const ChainParts&) const = default;
};

class Chain {
 public:
  // Errors name the state or row and what was expected: sizes that disagree, indices out of range, a zero count,
  // a row whose total reaches 2^32, rewards or Q-values that are not finite, a feature value that the vocabulary does
  // not list, two states with the same features (unless there may be look-alikes), and whatever else ChainParts says.
  static Result<Chain> make(ChainParts parts);

  const ChainParts& parts() const { return parts_; }
  const Vocabulary& vocabulary() const { return parts_.vocabulary; }
  std::size_t states() const { return parts_.policy.size(); }
  std::size_t actions() const { return parts_.vocabulary.actions.size(); }
  std::size_t transitions() const { return parts_.successor.size(); }
  std::uint32_t initial_state() const { return parts_.initial_state; }
  // Where episodes start: one share or more. A state's probability is its count / starts_total().
  std::span<const StartShare> starts() const { return starts_; }
  std::uint64_t starts_total() const { return starts_total_; }
  bool is_terminal(std::size_t state) const;
  bool is_forbidden(std::size_t state, std::size_t action) const {
    return !parts_.forbidden.empty() && parts_.forbidden[state * actions() + action] != 0;
  }
  // The index of the action that takes place where `chosen` is chosen (an index; actions(): none): itself, or what
  // NoAction says; actions(): the state is held. Every walk, exact figure and score goes by it.
  std::size_t taken(std::size_t state, std::size_t chosen) const {
    const bool own = chosen < actions() && !is_forbidden(state, chosen);
    return own ? chosen : (when_none_.empty() ? actions() : when_none_[state]);
  }
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
  // Of a pair's tries those that were collisions, in [0, 1]; 0 when never tried. REQUIRES: the chain says (collisions
  // is not empty).
  double collision_share(std::size_t row) const {
    return tries_[row] == 0 ? 0.0 : static_cast<double>(parts_.collisions[row]) / static_cast<double>(tries_[row]);
  }

 private:
  explicit Chain(ChainParts parts) : parts_(std::move(parts)) {}
  void settle();

  ChainParts parts_;
  std::vector<std::uint64_t> tries_;  // [states x actions]
  std::vector<StartShare> starts_;
  std::uint64_t starts_total_ = 1;
  std::vector<std::uint8_t> when_none_;  // [states], taken() of no action; empty: hold everywhere
};

// See NoAction::Kind::worst; the number of actions where none was tried. Both of one state: [actions].
std::size_t worst_action(std::span<const double> q, std::span<const std::uint64_t> tries);

// The greedy policy on q [states x actions]: the action of the highest value, ties to the lowest index.
std::vector<ActionId> greedy_policy(std::span<const double> q, std::size_t actions);

}  // namespace coppice
