// What a controller met in the simulator, counted as learning counts it (thesis VI-E.2), and a chain with it. Counts
// are real observations: a simulated step adds 1 to its (state, action, successor), its reward and,
// where the chain counts them, its collision to its (state, action), and changes nothing else. Q-values, the policy and
// the visits of learning stay: a simulated step teaches the policy nothing, and `visits` says how well it knows a
// state.
//
// An observation that learning never met becomes a state behind all others, in the order in which they were met. The
// Q-table has nothing for it, so it gets what learning starts a state with: Q-values of 0, on which the greedy policy
// takes action 0, with 0 visits. That is what the learned controller does there (simulate_policy()); nothing better
// founded is known, and whatever weighs states by visits, or looks at those seen, leaves such a state out.
//
// Owns its counts; one thread.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/chain/chain_builder.hpp"
#include "common/error.hpp"
#include "coordinator/learning/simulate.hpp"

namespace coppice {

// What an extended chain has more than the one that it came from.
struct Gains {
  std::uint64_t steps = 0;      // counted
  std::size_t states = 0;       // that it did not know
  std::size_t pairs = 0;        // (state, action) that were never tried before
  std::size_t transitions = 0;  // (state, action, successor) that were never seen before
  bool operator==(const Gains&) const = default;
};

struct Extended {
  Chain chain;
  Gains gains;
};

class Experience {
 public:
  // The chain must outlive it.
  explicit Experience(const Chain& chain);

  // REQUIRES: observations of the chain's vocabulary, an action of it.
  void add(const SimulatedStep& step);

  // The chain says what collides, and a step that was added did not.
  bool lacks_collisions() const { return lacks_collisions_; }

  // The chain with everything counted so far. Errors: a (state, action) tried 2^32 times; lacks_collisions().
  Result<Extended> extended() const;

 private:
  std::uint32_t state_of(std::span<const std::uint8_t> observation);
  // The state that ends episodes there: the one that looks so, else the first.
  std::uint32_t end_of(std::span<const std::uint8_t> observation);

  const Chain& chain_;
  // By observation, a byte a feature; of states that look alike the first that does not end
  // episodes speaks for all.
  std::unordered_map<std::string, std::uint32_t> state_of_;
  std::uint32_t states_;                    // known and new
  std::vector<std::uint8_t> new_features_;  // [new states x features]
  std::vector<double> reward_sum_;          // [states x actions], new states included
  std::vector<std::uint64_t> collisions_;   // the same; empty: the chain does not say what collides
  ChainBuilder counts_;
  std::uint64_t steps_ = 0;
  bool lacks_collisions_ = false;
};

}  // namespace coppice
