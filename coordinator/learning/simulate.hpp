// A controller in the simulator: what thesis Table IV calls "in simulation".
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/error.hpp"
#include "common/stop.hpp"
#include "common/tree/tree.hpp"
#include "coordinator/learning/world.hpp"

namespace coppice {

struct SimulateSettings {
  std::uint64_t episodes = 500;
  std::uint32_t steps = 150;  // per episode
  std::uint64_t seed = 1;
  std::uint64_t first_episode = 0;  // number of the first: episodes of other numbers have other luck
  const StopFlag* stop = nullptr;   // raised: an outside simulator is ended in the middle of an episode
};

// Asked between episodes; false to stop. May be empty.
using SimulateProgress = std::function<bool()>;

struct EpisodeRecord {
  double reward = 0.0;
  std::uint32_t steps = 0;    // taken; fewer than asked for when the episode ended at a goal
  std::uint32_t matches = 0;  // steps in which the controller's action was the chain's policy
  std::uint32_t collisions = 0;
  std::uint32_t unknown = 0;  // steps in a state that the chain does not know: never a match
};

// A step that a controller took, for those who watch. Spans hold during the call.
struct SimulatedStep {
  std::span<const std::uint8_t> before;  // [features] what was observed
  ActionId action{};                     // an action: a controller that holds still takes no step
  double reward = 0.0;
  // [features] What is observed then. Of a step that ends the episode it is where another one starts, as in the chain
  // (learning_loop.hpp).
  std::span<const std::uint8_t> after;
  // `after` is where the task ended, in a chain that has states for that.
  bool ended = false;
  std::optional<bool> collided = {};  // nothing: the simulator does not say
};
// Called behind every step. May be empty.
using SimulateWatch = std::function<void(const SimulatedStep&)>;

// Runs the tree, ticked on the true observation each step; with no action the agent holds still for the step (no
// reward). Every episode has its own stream of random numbers, f(seed, episode), so two controllers meet the same luck
// as far as their walks agree. [episodes] Errors: interrupted, when `go_on` said to stop; an outside world's simulator
// (external_simulator.hpp). REQUIRES: chain's vocabulary
// is the world's, check_tree(tree, vocabulary).
Result<std::vector<EpisodeRecord>> simulate_tree(const World& world, const Chain& chain, const Tree& tree,
                                                 const SimulateSettings& settings, const SimulateProgress& go_on = {},
                                                 const SimulateWatch& watch = {});

// The same for many trees, all on the same episodes; an outside world's simulator is started once. [trees][episodes]
// `done` is told how many trees are done; may be empty.
Result<std::vector<std::vector<EpisodeRecord>>> simulate_trees(const World& world, const Chain& chain,
                                                               std::span<const Tree> trees,
                                                               const SimulateSettings& settings,
                                                               const SimulateProgress& go_on = {},
                                                               const std::function<void(std::size_t)>& done = {});

// Runs the learned policy itself; in a state that the chain does not know it takes action 0 (what greedy on an
// empty row of Q gives).
Result<std::vector<EpisodeRecord>> simulate_policy(const World& world, const Chain& chain,
                                                   const SimulateSettings& settings,
                                                   const SimulateProgress& go_on = {});

}  // namespace coppice
